// A sample of the pairs that each stage of a run dropped or kept, with places at which a viewer can draw them.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include <volccd/numerics/types.hpp>
#include <volccd/pipelines/stage_observer.hpp>

namespace volccd {

enum class SampledKind : std::uint8_t { elements, vf, ee };

/// A pair and the centroids of its two elements or features in the middle of the step (t = 0.5).
struct SampledPair {
  SampledKind kind = SampledKind::elements;
  std::array<Vec3, 2> centroids;
};

/// Keeps, for each stage and outcome, the pairs with the smallest hashes. The sample therefore depends neither on the
/// number of workers nor on the order of the pairs, and a pair that is in the sample of one stage or step tends to be
/// in that of the next one.
class PairSampler final : public StageObserver {
 public:
  /// For runs on an executor with at most this number of workers. At most `capacity` pairs are kept for each stage and
  /// outcome.
  PairSampler(std::size_t stages, unsigned workers, std::size_t capacity);

  /// Removes all pairs. Must be called before each run but the first.
  void clear();

  /// The pairs that a stage kept or dropped, in ascending order of their hashes; each pair once, although a stage may
  /// process a pair repeatedly.
  std::vector<SampledPair> sample(std::size_t stage, bool kept) const;

  void observe(std::size_t stage, unsigned worker, const Step& step, std::span<const ElementPair> pairs,
               std::span<const std::uint8_t> keep) override;
  void observe(std::size_t stage, unsigned worker, const Step& step, FeatureKind kind,
               std::span<const FeaturePair> tests, std::span<const std::uint8_t> keep) override;

 private:
  /// The key is a hash of the kind of the pair and of its two slots.
  using Sample = std::map<std::uint64_t, SampledPair>;

  template <class Pair, class Centroids>
  void add(std::size_t stage, unsigned worker, SampledKind kind, std::span<const Pair> pairs,
           std::span<const std::uint8_t> keep, Centroids&& centroids);

  const std::size_t stages_, capacity_;
  std::vector<Sample> samples_;  ///< [worker][stage][kept]
};

}  // namespace volccd
