// The feature-culling strategy: which VF and EE tests the surviving element pairs give (assignment, O-Set; Section 5).
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include <volccd/core/stage.hpp>
#include <volccd/culling/element_culling.hpp>
#include <volccd/query/step.hpp>

namespace volccd {

/// Tests to run. No pair with a common vertex is ever in it.
struct TestBatch {
  std::vector<FeaturePair> vf, ee;

  void clear() {
    vf.clear();
    ee.clear();
  }
};

/// Completeness: the tests of all element pairs that the broad phase owes for `needs_adjacent_pairs()`, together with the
/// orphans, contain every feature pair without a common vertex whose features touch.
class FeatureCulling {
 public:
  virtual ~FeatureCulling() = default;

  /// Whether it relies on adjacent pairs and self pairs (o,o) being among the element pairs (PairRange::every), or lives
  /// with non-adjacent ones.
  virtual bool needs_adjacent_pairs() const = 0;

  /// Why the completeness argument does not hold for this configuration; empty if it does. A pipeline refuses to be made
  /// with the text as its reason.
  virtual std::string unsound() const { return {}; }

  /// Whether each test comes out at most once over the whole step.
  virtual bool exactly_once() const = 0;

  virtual std::unique_ptr<StageState> make_state() const = 0;

  /// Brings preprocessed tables in `state` (assignment, O-Set) up to the topology of the step: builds them at first, then
  /// updates them for the elements that came and went. One thread.
  virtual void update(const Step& step, StageState& state) const = 0;

  /// Appends the tests of these element pairs that no mask excludes. Concurrent calls allowed, on different `out`.
  virtual void tests(const Step& step, const StageState& state, const PairBatch& batch, TestBatch& out) const = 0;

  /// The tests that belong to no element pair (O-Set), in blocks that can be asked for independently and concurrently.
  /// Appends; at most a few thousand tests a block.
  virtual std::size_t orphan_blocks(const StageState& state) const = 0;
  virtual void orphans(const Step& step, const StageState& state, std::size_t block, TestBatch& out) const = 0;
};

}  // namespace volccd
