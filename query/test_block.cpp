#include <volccd/query/test_block.hpp>

#include <algorithm>
#include <cassert>
#include <utility>

namespace volccd {

void TestBlock::gather(const Step& step, FeatureKind kind, std::span<const FeaturePair> pairs) {
  assert(pairs.size() <= kCapacity);
  kind_ = kind;
  size_ = pairs.size();
  control_points_ = step.motion.control_points();
  std::copy(pairs.begin(), pairs.end(), pairs_.begin());
  for (std::size_t i = 0; i < size_; ++i) {
    vertices_[i] = test_vertices(step.features(), kind, pairs[i]);
    for (std::size_t p = 0; p < 4; ++p) {
      const double* x = step.motion.at(vertices_[i][p]);
      double* out = rows_ + p * 3 * kCapacity + i;
      for (int c = 0; c < control_points_; ++c, x += 3, out += 12 * kCapacity) {
        out[0] = x[0];
        out[kCapacity] = x[1];
        out[2 * kCapacity] = x[2];
      }
    }
  }
}

void TestBlock::compact(std::span<const std::uint8_t> keep) {
  assert(keep.size() >= size_);
  const auto end = keep.begin() + static_cast<std::ptrdiff_t>(size_);
  const auto first = static_cast<std::size_t>(std::find(keep.begin(), end, 0) - keep.begin());
  const std::size_t size = std::exchange(size_, first);
  take(*this, keep, first, size);
}

std::size_t TestBlock::append_kept(const TestBlock& from, std::span<const std::uint8_t> keep, std::size_t begin) {
  assert(&from != this && keep.size() >= from.size_);
  if (size_ == 0) {
    kind_ = from.kind_;
    control_points_ = from.control_points_;
  }
  assert(kind_ == from.kind_ && control_points_ == from.control_points_);
  return take(from, keep, begin, from.size_);
}

std::size_t TestBlock::take(const TestBlock& from, std::span<const std::uint8_t> keep, std::size_t begin,
                            std::size_t end) {
  std::array<std::uint8_t, kCapacity> kept;
  std::size_t count = 0;
  for (const std::size_t room = kCapacity - size_; begin < end && count < room; ++begin) {
    kept[count] = static_cast<std::uint8_t>(begin);  // without a branch: verdicts are hard to predict
    count += keep[begin] != 0 ? 1 : 0;
  }
  for (std::size_t k = 0; k < count; ++k) {
    pairs_[size_ + k] = from.pairs_[kept[k]];
    vertices_[size_ + k] = from.vertices_[kept[k]];
  }
  const std::size_t rows = static_cast<std::size_t>(control_points_) * 12;
  for (std::size_t row = 0; row < rows; ++row) {
    const double* source = from.rows_ + row * kCapacity;
    double* target = rows_ + row * kCapacity + size_;
    for (std::size_t k = 0; k < count; ++k) target[k] = source[kept[k]];
  }
  size_ += count;
  return begin;
}

}  // namespace volccd
