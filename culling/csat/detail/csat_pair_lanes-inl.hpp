// Points and rounding bounds of CSAT in single precision; each vector lane holds one element pair. Included once for
// each instruction set by foreach_target.h of Highway. Derivation of the bounds: docs/numerics.md, "Single precision".
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#include <volccd/numerics/vector_lanes-inl.hpp>
#include <volccd/query/pairs.hpp>

#if defined(VOLCCD_CSAT_PAIR_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef VOLCCD_CSAT_PAIR_LANES_INL
#undef VOLCCD_CSAT_PAIR_LANES_INL
#else
#define VOLCCD_CSAT_PAIR_LANES_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

/// Half the distance from 1 to the next float.
constexpr float kFloatRoundoff = 0x1p-24f;
/// A lane whose sum of magnitudes exceeds this value is regarded as not separated.
constexpr float kFloatGreatestMagnitude = 0x1p100f;

/// Gap along an axis L as in numerics/rounding.hpp, for differences that are computed in doubles and rounded once to
/// floats:
///     T = float_gap_error_factor(n) * S + kFloatGapUnderflow [+ separation term],   S = |Lx| Dx + |Ly| Dy + |Lz| Dz
/// where Dk = max(kFloatMinExtent, max |xk - rk| as a float), and n levels of de Casteljau's algorithm are applied to
/// the floats.
constexpr float float_gap_error_factor(int levels) { return static_cast<float>(10 + 6 * levels) * kFloatRoundoff; }
constexpr float kFloatGapUnderflow = 0x1p-145f;
constexpr float kFloatMinExtent = 0x1p-126f;

/// Compensates for rounding when a length is multiplied by a separation and added to a sum.
constexpr float kFloatLengthSlack = 1 + 16 * kFloatRoundoff;
/// For sums of squares below this value, the sum of absolute values replaces the length.
constexpr float kFloatMinSquare = 0x1p-100f;

/// The separation as a float: at least `separation`, except for one relative rounding; infinite beyond the range of the
/// kernels.
HWY_INLINE float float_separation(double separation) {
  if (separation == 0) return 0;
  if (!(separation < kFloatGreatestMagnitude)) return std::numeric_limits<float>::infinity();
  return std::max(static_cast<float>(separation), std::numeric_limits<float>::min());
}

using PairTag = hn::CappedTag<float, 8>;
using PairLanes = hn::Vec<PairTag>;
using PairMask = hn::Mask<PairTag>;
using PairLanes3 = LaneVector<PairLanes>;

HWY_INLINE PairLanes in_lanes(float x) { return hn::Set(PairTag(), x); }

#if HWY_TARGET == HWY_SCALAR
/// The same as load_differences() for vectors below, for targets without vectors.
template <int kControlPoints>
HWY_INLINE PairLanes3 load_differences(const double* const* p, const double* const* r, int c) {
  const auto difference = [&](int k) { return in_lanes(static_cast<float>(p[0][3 * c + k] - r[0][3 * c + k])); };
  return {difference(0), difference(1), difference(2)};
}
#else
using PointTag = hn::FixedTag<float, 4>;

/// Differences of four doubles and four others, rounded to floats.
template <class D>
HWY_INLINE hn::Vec<PointTag> float_difference(D d, const double* a, const double* b) {
  const PointTag four;
  if constexpr (hn::MaxLanes(D()) == 4) {
    return hn::DemoteTo(four, hn::Sub(hn::LoadU(d, a), hn::LoadU(d, b)));
  } else {
    const hn::Half<PointTag> two;
    return hn::Combine(four, hn::DemoteTo(two, hn::Sub(hn::LoadU(d, a + 2), hn::LoadU(d, b + 2))),
                       hn::DemoteTo(two, hn::Sub(hn::LoadU(d, a), hn::LoadU(d, b))));
  }
}

/// float_difference() of the points with index `lane` and, in the upper half of 8 lanes, `lane + 4`, beginning at
/// `offset`.
template <class D>
HWY_INLINE hn::Vec<D> float_differences(D d, const double* const* p, const double* const* r, std::size_t lane,
                                        std::size_t offset) {
  const hn::CappedTag<double, 4> four;
  const auto low = float_difference(four, p[lane] + offset, r[lane] + offset);
  if constexpr (hn::MaxLanes(D()) == 8) {
    return hn::Combine(d, float_difference(four, p[lane + 4] + offset, r[lane + 4] + offset), low);
  } else {
    return low;
  }
}

/// The differences p - r of control point c of one vertex for a register of pairs, computed in doubles and rounded to
/// floats. Four doubles are loaded at once; the superfluous coordinate belongs to another control point.
template <int kControlPoints>
HWY_INLINE PairLanes3 load_differences(const double* const* p, const double* const* r, int c) {
  const PairTag tag;
  const bool last = c == kControlPoints - 1;
  const auto offset = static_cast<std::size_t>(last ? 3 * c - 1 : 3 * c);
  const PairLanes a0 = float_differences(tag, p, r, 0, offset), a1 = float_differences(tag, p, r, 1, offset);
  const PairLanes a2 = float_differences(tag, p, r, 2, offset), a3 = float_differences(tag, p, r, 3, offset);
  const PairLanes low0 = hn::InterleaveLower(tag, a0, a2), low1 = hn::InterleaveLower(tag, a1, a3);
  const PairLanes high0 = hn::InterleaveUpper(tag, a0, a2), high1 = hn::InterleaveUpper(tag, a1, a3);
  const PairLanes second = hn::InterleaveUpper(tag, low0, low1), third = hn::InterleaveLower(tag, high0, high1);
  if (last) return {second, third, hn::InterleaveUpper(tag, high0, high1)};
  return {hn::InterleaveLower(tag, low0, low1), second, third};
}
#endif

/// Pairs (a, b) of elements with equal numbers of vertices: the same number for each a, and the same number for each b.
struct PairList {
  static constexpr std::size_t kPairs = 8, kVertices = 8;

  std::size_t size = 0;
  std::size_t counts[2] = {};  ///< numbers of vertices
  Index first[kPairs];         ///< elements a
  const Index* vertices[2][kPairs];
  std::uint8_t index[kPairs];  ///< index of each pair in the input

  /// Whether the elements of pair i have a common vertex.
  bool adjacent(std::size_t i) const {
    bool common = false;
    for (std::size_t v = 0; v < counts[0]; ++v)
      for (std::size_t w = 0; w < counts[1]; ++w) common |= vertices[0][i][v] == vertices[1][i][w];
    return common;
  }
};

/// The threshold that a gap along an axis must exceed. The Dk are the coordinates of `extent`.
struct PairThreshold {
  PairLanes error, separation;
  PairMask trusted;  ///< lanes without overflow

  HWY_INLINE PairThreshold(const PairLanes3& axis, const PairLanes3& extent, int levels, float distance) {
    const PairLanes sum = dot(abs(axis), extent);
    error = hn::Add(hn::Mul(in_lanes(float_gap_error_factor(levels)), sum), in_lanes(kFloatGapUnderflow));
    separation = in_lanes(0);
    if (distance != 0)
      separation = hn::Mul(in_lanes(distance), hn::Mul(length_bound(axis), in_lanes(kFloatLengthSlack)));
    trusted = hn::Lt(sum, in_lanes(kFloatGreatestMagnitude));
  }

  HWY_INLINE PairMask exceeded(PairLanes gap) const {
    return hn::And(trusted, hn::Gt(gap, hn::Add(error, separation)));
  }

  /// Lanes in which the exact gap is certainly less than the separation, by much more than all rounding errors.
  HWY_INLINE PairMask missed(PairLanes gap) const {
    return hn::And(trusted, hn::Lt(hn::Add(gap, hn::Mul(in_lanes(32), error)), separation));
  }

 private:
  /// An upper bound on the length, except for a rounding error for which kFloatLengthSlack compensates.
  static HWY_INLINE PairLanes length_bound(const PairLanes3& axis) {
    const PairLanes square = dot(axis, axis);
    return hn::IfThenElse(hn::Gt(square, in_lanes(kFloatMinSquare)), hn::Sqrt(square), norm1(axis));
  }
};

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
