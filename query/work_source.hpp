// Sources of work: stages that hand out element pairs and tests, block by block.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include <volccd/query/pairs.hpp>
#include <volccd/query/stage.hpp>

namespace volccd {

/// Tests to perform. It never contains a pair of features with a common vertex.
struct TestBatch {
  std::vector<FeaturePair> vf, ee;

  std::size_t size() const { return vf.size() + ee.size(); }
  /// Numbers of VF and of EE tests.
  std::pair<std::size_t, std::size_t> sizes() const { return {vf.size(), ee.size()}; }
  /// Appends the tests begin .. end - 1 of another batch, where the EE tests follow the VF tests.
  void append(const TestBatch& other, std::size_t begin, std::size_t end) {
    const auto part = [&](const std::vector<FeaturePair>& from, std::size_t first, std::vector<FeaturePair>& to) {
      const auto at = [&](std::size_t i) {
        return from.begin() + static_cast<std::ptrdiff_t>(std::clamp(i, first, first + from.size()) - first);
      };
      to.insert(to.end(), at(begin), at(end));
    };
    part(other.vf, 0, vf);
    part(other.ee, other.vf.size(), ee);
  }
  void clear() {
    vf.clear();
    ee.clear();
  }
};

/// What a source hands out. Each worker has one; a source appends to it.
struct Work {
  std::vector<ElementPair> pairs;
  TestBatch tests;
};

/// What the blocks of a round contain, and how it is processed.
enum class RoundKind {
  pairs,           ///< element pairs: culled for the whole step; the tests of those that survive are assigned
  pairs_at_start,  ///< element pairs: culled for t = 0 only, to be given back; no tests are assigned
  tests            ///< tests
};

/// A part of a source's work whose blocks may be processed at the same time.
struct Round {
  std::size_t blocks = 0;  ///< 0: the source has no more work in this step
  RoundKind kind = RoundKind::pairs;
};

/// Base of BroadPhase, OrphanSource and Flood. After prepare(), the pipeline asks for round 0, 1, ... until one has no
/// blocks. It runs each block of a round once, on any worker, and gives a flood the survivors of the round back before
/// it asks for the next round.
class WorkSource : public Stage {
 public:
  /// Begins a round. Runs alone, and may use the executor. The set of pairs and tests of a round does not depend on the
  /// number of workers.
  virtual Round next_round(const Step& step, StageState& state, std::size_t number, Executor& executor) const = 0;

  /// Appends the work of one block of the present round, of the kind of the round.
  virtual void run(const Step& step, StageState& state, unsigned worker, std::size_t block, Work& out) const = 0;

  /// Of a flood only: receives pairs of the present round that element culling has not proven to be disjoint: those
  /// that it kept, and those that it removed as PairVerdict::contact_free. Called by several workers at the same time.
  virtual void record_survivors(StageState& state, unsigned worker, std::span<const ElementPair> pairs) const {
    (void)state, (void)worker, (void)pairs;
  }
};

}  // namespace volccd
