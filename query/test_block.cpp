#include <volccd/query/test_block.hpp>

#include <cassert>
#include <utility>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/query/test_block.cpp"
#include <hwy/foreach_target.h>
#include <volccd/query/vertex_records-inl.hpp>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

/// Pre: the number of tests is a multiple of 4.
void gather_rows(const Motion& motion, std::span<const std::array<Index, 4>> tests, double* rows) {
  (motion.control_points() == 2 ? gather_tests<TestBlock::kCapacity, 2>
                                : gather_tests<TestBlock::kCapacity, 3>)(motion, tests, rows);
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd {

namespace detail {
HWY_EXPORT(gather_rows);
}

void TestBlock::gather(const Step& step, FeatureKind kind, std::span<const FeaturePair> pairs) {
  assert(pairs.size() <= kCapacity);
  kind_ = kind;
  size_ = pairs.size();
  control_points_ = step.motion.control_points();
  assert(control_points_ >= 2 && control_points_ <= kMaxControlPoints);
  if (size_ == 0) return;
  const Features& features = step.features();
  for (std::size_t i = 0; i < size_; ++i) {
    pairs_[i] = pairs[i];
    vertices_[i] = test_vertices(features, kind, pairs[i]);
  }
  for (std::size_t i = size_; i < padded_size(); ++i) vertices_[i] = vertices_[size_ - 1];
  using namespace detail;
  HWY_DYNAMIC_DISPATCH(gather_rows)(step.motion, std::span(vertices_).first(padded_size()), rows_);
}

void TestBlock::compact(std::span<const std::uint8_t> keep) {
  assert(keep.size() >= size_);
  const std::size_t size = std::exchange(size_, 0);
  take(*this, keep, 0, size);
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
    kept[count] = static_cast<std::uint8_t>(begin);  // without a branch, because the flags are hard to predict
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
#endif
