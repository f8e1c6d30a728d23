#include <volccd/mesh/feature_block.hpp>

#include <algorithm>
#include <cassert>

namespace volccd {

std::array<Index, 4> test_vertices(const Features& features, FeatureKind kind, FeaturePair pair) {
  if (kind == FeatureKind::vf) {
    const std::array<Index, 3>& f = features.triangle(pair.b);
    return {pair.a, f[0], f[1], f[2]};
  }
  const std::array<Index, 2>& a = features.edge(pair.a);
  const std::array<Index, 2>& b = features.edge(pair.b);
  return a < b ? std::array{a[0], a[1], b[0], b[1]} : std::array{b[0], b[1], a[0], a[1]};
}

bool is_test(const Features& features, FeatureKind kind, FeaturePair pair) {
  if (kind == FeatureKind::vf) {
    const std::array<Index, 3>& f = features.triangle(pair.b);
    return pair.a != f[0] && pair.a != f[1] && pair.a != f[2];
  }
  const std::array<Index, 2>& a = features.edge(pair.a);
  const std::array<Index, 2>& b = features.edge(pair.b);
  return a[0] != b[0] && a[0] != b[1] && a[1] != b[0] && a[1] != b[1];
}

void FeatureBlock::gather(const Step& step, FeatureKind kind, std::span<const FeaturePair> pairs) {
  assert(pairs.size() <= kCapacity);
  kind_ = kind;
  size_ = pairs.size();
  const int points = step.motion.control_points();
  if (storage_.empty() || points != control_points_) {
    control_points_ = points;
    storage_.resize(static_cast<std::size_t>(points) * 12 * kCapacity + 8);
    rows_ = storage_.data();
    while (reinterpret_cast<std::uintptr_t>(rows_) % 64 != 0) ++rows_;
  }
  const std::size_t padded = padded_size();
  for (std::size_t i = 0; i < padded; ++i) {
    const std::array<Index, 4> v = test_vertices(step.features(), kind, pairs[std::min(i, size_ - 1)]);
    for (std::size_t p = 0; p < 4; ++p) {
      const double* x = step.motion.at(v[p]);
      double* out = rows_ + p * 3 * kCapacity + i;
      for (int c = 0; c < points; ++c, x += 3, out += 12 * kCapacity) {
        out[0] = x[0];
        out[kCapacity] = x[1];
        out[2 * kCapacity] = x[2];
      }
    }
  }
}

}  // namespace volccd
