#include <volccd/query/test_block.hpp>

#include <algorithm>
#include <cassert>
#include <utility>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/query/test_block.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using RecordTag = hn::CappedTag<double, 4>;
constexpr int kLanes = static_cast<int>(hn::MaxLanes(RecordTag()));

/// Offset of double k of a vertex's record in Motion, relative to the first row of that vertex in the tests.
constexpr std::size_t row_offset(int k) { return static_cast<std::size_t>(k / 3 * 12 + k % 3) * TestBlock::kCapacity; }

/// Transposes the doubles kFirst .. kFirst + kLanes - 1 of kLanes records, and stores those with numbers from kFrom on.
template <int kFirst, int kFrom>
HWY_INLINE void transpose(const double* const (&records)[4], double* rows) {
  const RecordTag d;
  const auto load = [&](int i) HWY_ATTR { return hn::LoadU(d, records[i] + kFirst); };
  const auto store = [&](hn::Vec<RecordTag> values, int k)
                         HWY_ATTR { if (k >= kFrom) hn::Store(values, d, rows + row_offset(kFirst + k)); };
#if HWY_TARGET == HWY_SCALAR
  store(load(0), 0);
#else
  if constexpr (kLanes == 2) {
    const auto a = load(0), b = load(1);
    store(hn::InterleaveLower(d, a, b), 0);
    store(hn::InterleaveUpper(d, a, b), 1);
  } else {
    const auto a = load(0), b = load(1), c = load(2), e = load(3);
    const auto even0 = hn::InterleaveLower(d, a, b), even1 = hn::InterleaveLower(d, c, e);
    const auto odd0 = hn::InterleaveUpper(d, a, b), odd1 = hn::InterleaveUpper(d, c, e);
    store(hn::ConcatLowerLower(d, even1, even0), 0);
    store(hn::ConcatLowerLower(d, odd1, odd0), 1);
    store(hn::ConcatUpperUpper(d, even1, even0), 2);
    store(hn::ConcatUpperUpper(d, odd1, odd0), 3);
  }
#endif
}

/// Transposes records of kDoubles doubles, beginning with double kFirst.
template <int kDoubles, int kFirst = 0>
HWY_INLINE void transpose_records(const double* const (&records)[4], double* rows) {
  if constexpr (kFirst + kLanes <= kDoubles) {
    transpose<kFirst, 0>(records, rows);
    transpose_records<kDoubles, kFirst + kLanes>(records, rows);
  } else if constexpr (kFirst < kDoubles) {
    transpose<kDoubles - kLanes, kFirst - (kDoubles - kLanes)>(records, rows);
  }
}

template <int kDoubles>
void gather_records(const Motion& motion, std::span<const std::array<Index, 4>> tests, double* rows) {
  const double* all = motion.at(0);
  for (std::size_t i = 0; i < tests.size(); i += kLanes)
    for (std::size_t p = 0; p < 4; ++p) {
      const double* records[4] = {};
      for (std::size_t k = 0; k < kLanes; ++k) records[k] = all + std::size_t{tests[i + k][p]} * kDoubles;
      transpose_records<kDoubles>(records, rows + p * 3 * TestBlock::kCapacity + i);
    }
}

/// Pre: the number of tests is a multiple of 4.
void gather_rows(const Motion& motion, std::span<const std::array<Index, 4>> tests, double* rows) {
  (motion.control_points() == 2 ? gather_records<6> : gather_records<9>)(motion, tests, rows);
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
