// The narrow-phase strategy: elementary tests, in batches of one kind.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <volccd/query/contact.hpp>
#include <volccd/query/stage.hpp>
#include <volccd/query/test_block.hpp>

namespace volccd {

/// Counters that the pipeline sums over batches.
struct NarrowCounters {
  /// Tests that a rule for degenerate geometry decided (coplanar at all times, triangle without area, ...).
  std::uint64_t degenerate = 0;
  /// Tests that could not be decided within the stated bounds and were answered conservatively.
  std::uint64_t undecided = 0;
};

class NarrowPhase : public Stage {
 public:
  static constexpr const char* kRole = "narrow-phase";

  /// Largest number of control points that it supports: 2 (constant velocity) or 3 (constant acceleration).
  virtual int max_control_points() const { return 2; }
  /// Whether it supports step.separation > 0.
  virtual bool handles_separation() const { return false; }
  /// By how much the reported time of a contact may be early, as a fraction of the step.
  virtual double time_tolerance() const { return 0; }

  /// Appends a Contact for each test of the block whose features touch during [0, step.t_max], in the order of the
  /// block. It may also append a contact that occurs after t_max, by at most time_tolerance(), if its reported time is
  /// at most t_max. The result of a test depends only on the coordinates of its vertices in the order of
  /// test_vertices(), not on the block; therefore contacts are the same bit for bit in every pipeline. A test whose
  /// features touch at t = 0 has toi 0. Pre: the block is not empty.
  virtual void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block,
                   std::vector<Contact>& contacts, NarrowCounters& counters) const = 0;

  /// Finds, at little cost, contacts that last from the step before: for the tests of a candidate list, of which most
  /// are such contacts, before any filter has seen them. Appends, in the order of the block, some of the contacts with
  /// Contact::at_start that run() would append, and sets keep[i] to 0 for their tests; looks only at tests with keep[i]
  /// != 0. O(block), no allocation but for contacts. Pre: keep.size() >= block.padded_size().
  virtual void find_at_start(const Step& step, const TestBlock& block, std::vector<Contact>& contacts,
                             std::span<std::uint8_t> keep) const {
    (void)step, (void)block, (void)contacts, (void)keep;
  }
};

}  // namespace volccd
