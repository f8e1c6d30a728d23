// The narrow-phase strategy: elementary tests, in batches of one kind.
#pragma once

#include <cstdint>
#include <vector>

#include <volccd/query/contact.hpp>
#include <volccd/query/stage.hpp>
#include <volccd/query/test_block.hpp>

namespace volccd {

/// Summed over batches by the pipeline.
struct NarrowCounters {
  /// Tests whose answer came from a rule for degenerate geometry (coplanar all along, zero-area triangle, ...).
  std::uint64_t degenerate = 0;
  /// Tests that could not be decided within the stated bounds and were answered conservatively.
  std::uint64_t undecided = 0;
};

class NarrowPhase : public Stage {
 public:
  static constexpr const char* kRole = "narrow-phase";

  /// Degrees of motion that it handles: 2 for two control points only, 3 for up to three.
  virtual int max_control_points() const { return 2; }
  /// Whether it handles step.separation > 0.
  virtual bool handles_separation() const { return false; }
  /// By how much of the step the time of a contact may be too early.
  virtual double time_tolerance() const { return 0; }

  /// Appends a Contact for each test of the block that touches during [0, step.t_max], in the order of the block;
  /// perhaps also for one that touches later than t_max by at most time_tolerance(), and whose time is reported as
  /// t_max or less. The answer to a test depends on the coordinates of its vertices in the order of test_vertices()
  /// alone, not on the block: contacts are the same bit for bit whatever pipeline asks. A test that touches at t = 0
  /// has toi 0. Pre: the block is not empty.
  virtual void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block,
                   std::vector<Contact>& contacts, NarrowCounters& counters) const = 0;
};

}  // namespace volccd
