// An observer of the pairs that the stages of a run take, drop and keep.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <volccd/query/pairs.hpp>
#include <volccd/query/step.hpp>

namespace volccd {

/// A run with an observer (Request::observer) hands it every batch of pairs that a stage has processed; it runs as
/// without one. `stage` is the index of the stage in Statistics::stages, and keep[i] tells whether the stage kept pair
/// i. An empty `keep` means that the stage produced the pairs: a broad phase, an assignment, an orphan source, and a
/// flood with the pairs that it proposes and with its orphans. A narrow phase keeps the tests that are contacts.
///
/// For each stage, the numbers of all pairs and of those kept are StageStatistics::in and `out`, with two exceptions:
/// a flood counts in `in` the survivors that it receives, and it counts its orphans in Statistics::orphan_tests only.
/// The test of initial overlaps is not observed.
///
/// Thread rule: calls with different values of `worker`, which is below the executor's workers(), are concurrent. The
/// arguments are valid during the call. An exception ends the run. Measure times without an observer.
class StageObserver {
 public:
  virtual ~StageObserver() = default;

  /// Element slots are those of `step`, on which the stage ran. In a step that a flood takes, these are the simplices
  /// of its complex.
  virtual void observe(std::size_t stage, unsigned worker, const Step& step, std::span<const ElementPair> pairs,
                       std::span<const std::uint8_t> keep) = 0;

  /// Tests on features of the mesh.
  virtual void observe(std::size_t stage, unsigned worker, const Step& step, FeatureKind kind,
                       std::span<const FeaturePair> tests, std::span<const std::uint8_t> keep) = 0;
};

}  // namespace volccd
