#include <volccd/query/test_block.hpp>

#include <algorithm>
#include <cassert>

namespace volccd {

void TestBlock::gather(const Step& step, FeatureKind kind, std::span<const FeaturePair> pairs) {
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
