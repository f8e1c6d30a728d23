// The narrow-phase strategy: elementary tests, in batches of one kind.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <volccd/core/stage.hpp>
#include <volccd/query/contact.hpp>
#include <volccd/query/step.hpp>
#include <volccd/query/test_block.hpp>

namespace volccd {

/// Summed over batches by the pipeline.
struct NarrowCounters {
  /// Tests whose answer came from a rule for degenerate geometry (coplanar all along, zero-area triangle, ...).
  std::uint64_t degenerate = 0;
  /// Tests that could not be decided within the stated bounds and were answered conservatively.
  std::uint64_t undecided = 0;
};

class NarrowPhase {
 public:
  virtual ~NarrowPhase() = default;

  /// Degrees of motion that it handles: 2 for two control points only, 3 for up to three.
  virtual int max_control_points() const { return 2; }
  /// Whether it handles step.separation > 0.
  virtual bool handles_separation() const { return false; }
  /// By how much of the step the time of a contact may be too early.
  virtual double time_tolerance() const { return 0; }

  /// Appends a Contact for each test that touches during [0, step.t_max], in the order of `pairs`; perhaps also for one
  /// that touches later than t_max by at most time_tolerance(), and whose time is reported as t_max or less. The answer to a pair
  /// depends on the coordinates of its vertices in the order of test_vertices() alone, not on the batch: contacts are
  /// the same bit for bit whatever pipeline asks. A pair that touches at t = 0 has toi 0. Concurrent calls allowed.
  virtual void test(const Step& step, FeatureKind kind, std::span<const FeaturePair> pairs,
                    std::vector<Contact>& contacts, NarrowCounters& counters) const = 0;
};

}  // namespace volccd
