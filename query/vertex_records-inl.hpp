// Gathers the coordinates of moving vertices into rows of lanes, by transposition. Included once for each instruction
// set by foreach_target.h of Highway.
#include <array>
#include <cstddef>
#include <span>

#include <hwy/highway.h>

#include <volccd/query/motion.hpp>

#if defined(VOLCCD_VERTEX_RECORDS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef VOLCCD_VERTEX_RECORDS_INL
#undef VOLCCD_VERTEX_RECORDS_INL
#else
#define VOLCCD_VERTEX_RECORDS_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using RecordTag = hn::CappedTag<double, 4>;
constexpr int kRecordLanes = static_cast<int>(hn::MaxLanes(RecordTag()));

/// Transposes the doubles kFirst .. kFirst + kRecordLanes - 1 of kRecordLanes records, and stores those with numbers
/// from kFrom on: double k at rows + Rows::offset(k).
template <class Rows, int kFirst, int kFrom>
HWY_INLINE void transpose(const double* const (&records)[4], double* rows) {
  const RecordTag d;
  const auto load = [&](int i) HWY_ATTR { return hn::LoadU(d, records[i] + kFirst); };
  const auto store = [&](hn::Vec<RecordTag> values, int k) HWY_ATTR {
    if (k >= kFrom) hn::Store(values, d, rows + Rows::offset(kFirst + k));
  };
#if HWY_TARGET == HWY_SCALAR
  store(load(0), 0);
#else
  if constexpr (kRecordLanes == 2) {
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
template <class Rows, int kDoubles, int kFirst = 0>
HWY_INLINE void transpose_records(const double* const (&records)[4], double* rows) {
  if constexpr (kFirst + kRecordLanes <= kDoubles) {
    transpose<Rows, kFirst, 0>(records, rows);
    transpose_records<Rows, kDoubles, kFirst + kRecordLanes>(records, rows);
  } else if constexpr (kFirst < kDoubles) {
    transpose<Rows, kDoubles - kRecordLanes, kFirst - (kDoubles - kRecordLanes)>(records, rows);
  }
}

/// Stores coordinate k % 3 of control point k / 3 of the vertex vertex_of(i), for i < count, at rows[Rows::offset(k) +
/// i]. Pre: the motion has kControlPoints, count is a multiple of 4, and rows are aligned to four doubles.
template <class Rows, int kControlPoints, class VertexOf>
HWY_INLINE void gather_records(const Motion& motion, std::size_t count, VertexOf&& vertex_of, double* rows) {
  constexpr int doubles = 3 * kControlPoints;
  const double* const all = motion.at(0);
  for (std::size_t i = 0; i < count; i += kRecordLanes) {
    const double* records[4] = {};
    for (std::size_t k = 0; k < kRecordLanes; ++k) records[k] = all + std::size_t{vertex_of(i + k)} * doubles;
    transpose_records<Rows, doubles>(records, rows + i);
  }
}

/// Rows of tests of four vertices, kCapacity doubles apart: those of a control point follow each other.
template <std::size_t kCapacity>
struct TestRows {
  static constexpr std::size_t offset(int k) { return static_cast<std::size_t>(k / 3 * 12 + k % 3) * kCapacity; }
};

/// Gathers tests of four vertices. Preconditions as above.
template <std::size_t kCapacity, int kControlPoints>
HWY_INLINE void gather_tests(const Motion& motion, std::span<const std::array<Index, 4>> tests, double* rows) {
  for (std::size_t p = 0; p < 4; ++p)
    gather_records<TestRows<kCapacity>, kControlPoints>(
        motion, tests.size(), [&](std::size_t i) HWY_ATTR { return tests[i][p]; }, rows + 3 * p * kCapacity);
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
