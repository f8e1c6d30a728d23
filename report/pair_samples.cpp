#include <volccd/report/pair_samples.hpp>

#include <iterator>

#include <volccd/core/random.hpp>

namespace volccd {

namespace {

constexpr double kMiddle = 0.5;

/// A part of an element may repeat its first vertex at the end.
Vec3 centroid(const Motion& motion, std::span<const Index> vertices) {
  while (vertices.size() > 1 && vertices.back() == vertices.front()) vertices = vertices.first(vertices.size() - 1);
  Vec3 sum = Vec3::Zero();
  for (const Index v : vertices) sum += motion.position(v, kMiddle);
  return sum / static_cast<double>(vertices.size());
}

}  // namespace

PairSampler::PairSampler(std::size_t stages, unsigned workers, std::size_t capacity)
    : stages_(stages), capacity_(capacity), samples_(2 * stages * workers) {}

void PairSampler::clear() {
  for (Sample& sample : samples_) sample.clear();
}

std::vector<SampledPair> PairSampler::sample(std::size_t stage, bool kept) const {
  Sample all;
  for (std::size_t i = 2 * stage + (kept ? 1 : 0); i < samples_.size(); i += 2 * stages_)
    all.insert(samples_[i].begin(), samples_[i].end());
  std::vector<SampledPair> pairs;
  for (const auto& [hash, pair] : all)
    if (pairs.size() < capacity_) pairs.push_back(pair);
  return pairs;
}

template <class Pair, class Centroids>
void PairSampler::add(std::size_t stage, unsigned worker, SampledKind kind, std::span<const Pair> pairs,
                      std::span<const std::uint8_t> keep, Centroids&& centroids) {
  if (capacity_ == 0) return;
  const std::size_t first = 2 * (worker * stages_ + stage);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const std::uint64_t hash = hash_ids(hash_ids(static_cast<std::uint64_t>(kind), pairs[i].a), pairs[i].b);
    Sample& sample = samples_.at(first + (keep.empty() || keep[i] != 0 ? 1 : 0));
    if (sample.size() == capacity_ && sample.rbegin()->first <= hash) continue;
    sample.try_emplace(hash, SampledPair{kind, centroids(pairs[i])});
    if (sample.size() > capacity_) sample.erase(std::prev(sample.end()));
  }
}

void PairSampler::observe(std::size_t stage, unsigned worker, const Step& step, std::span<const ElementPair> pairs,
                          std::span<const std::uint8_t> keep) {
  add(stage, worker, SampledKind::elements, pairs, keep, [&](ElementPair pair) {
    return std::array{centroid(step.motion, step.mesh().vertices(pair.a)),
                      centroid(step.motion, step.mesh().vertices(pair.b))};
  });
}

void PairSampler::observe(std::size_t stage, unsigned worker, const Step& step, FeatureKind kind,
                          std::span<const FeaturePair> tests, std::span<const std::uint8_t> keep) {
  const bool vf = kind == FeatureKind::vf;
  add(stage, worker, vf ? SampledKind::vf : SampledKind::ee, tests, keep, [&](FeaturePair test) {
    const std::array<Index, 4> v = test_vertices(step.features(), kind, test);
    const std::span<const Index> all(v);
    const std::size_t first = vf ? 1 : 2;
    return std::array{centroid(step.motion, all.first(first)), centroid(step.motion, all.subspan(first))};
  });
}

}  // namespace volccd
