// The points and projections of CSAT in single precision; each vector lane holds one element pair. Included once for
// each instruction set by foreach_target.h of Highway.
#include <cstddef>
#include <cstdint>
#include <limits>

#include <volccd/culling/csat/csat_points.hpp>
#include <volccd/culling/csat/detail/csat_pair_lanes-inl.hpp>
#include <volccd/query/step.hpp>

#if defined(VOLCCD_CSAT_PAIR_GROUP_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef VOLCCD_CSAT_PAIR_GROUP_INL
#undef VOLCCD_CSAT_PAIR_GROUP_INL
#else
#define VOLCCD_CSAT_PAIR_GROUP_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

/// The control points of the pairs of a list, relative to the first vertex of the first element of each pair, and their
/// projections. The argument `lane` is the first lane of a register.
template <int kControlPoints>
class PairGroup {
 public:
  PairGroup(const CsatFrame& frame, const Step& step)
      : interval_(frame.interval), points_(step.motion.at(0)), separation_(float_separation(step.separation)) {
    std::fill_n(first_, kPairs, kNone);
  }

  /// Reads the points of all pairs. Unused lanes get copies of the first pair. A register that already holds the points
  /// of its first elements is not read again.
  void gather(PairList& list) {
    for (std::size_t lane = list.size; lane < kPairs; ++lane) {
      list.first[lane] = list.first[0];
      for (auto& vertices : list.vertices) vertices[lane] = vertices[0];
    }
    count_[0] = list.counts[0];
    count_[1] = list.counts[1];
    for (std::size_t lane = 0; lane < kPairs; lane += hn::Lanes(PairTag())) {
      gather_first(list.first + lane, list.vertices[0] + lane, lane);
      list.size == 1 ? spread(1, list.vertices[1][0], lane) : gather(1, list.vertices[1] + lane, lane);
    }
  }

  float separation() const { return separation_; }

  /// Number of vertices of each element, or 0 if the two elements have different numbers.
  std::size_t count() const { return count_[0] == count_[1] ? count_[0] : 0; }

  /// Greatest magnitude on each axis over the whole step.
  HWY_INLINE PairLanes3 extent(std::size_t lane) const { return max(load(0, kExtent, lane), load(1, kExtent, lane)); }

  /// The vector from the mean of the control points of the first elements to that of the second elements.
  HWY_INLINE PairLanes3 centroid_difference(std::size_t lane) const {
    const auto mean = [&](std::size_t side) HWY_ATTR {
      return scaled(load(side, kTotal, lane), in_lanes(1 / static_cast<float>(count_[side] * kControlPoints)));
    };
    return sub(mean(1), mean(0));
  }

  HWY_INLINE PairThreshold threshold(const PairLanes3& axis, const PairLanes3& extent) const {
    return {axis, extent, interval_.levels, separation_};
  }

  /// The smallest gap over all control points, where the gap is the distance by which b is beyond a along the axis.
  /// kCount: number of vertices of each element, or 0 for any number.
  template <std::size_t kCount>
  HWY_INLINE PairLanes gap(const PairLanes3& axis, std::size_t lane) const {
    const std::size_t counts[2] = {kCount != 0 ? kCount : count_[0], kCount != 0 ? kCount : count_[1]};
    PairLanes min = in_lanes(std::numeric_limits<float>::infinity());
    for (int c = 0; c < kControlPoints; ++c) {
      PairLanes high = dot(axis, point(0, 0, c, lane)), low = dot(axis, point(1, 0, c, lane));
      for (std::size_t v = 1; v < counts[0]; ++v) high = hn::Max(high, dot(axis, point(0, v, c, lane)));
      for (std::size_t v = 1; v < counts[1]; ++v) low = hn::Min(low, dot(axis, point(1, v, c, lane)));
      min = hn::Min(min, hn::Sub(low, high));
    }
    return min;
  }

  /// The same; also returns the difference b - a of the points at which the gap is smallest.
  HWY_INLINE PairLanes support(const PairLanes3& axis, std::size_t lane, PairLanes3& difference) const {
    PairLanes min = in_lanes(std::numeric_limits<float>::infinity());
    difference = {min, min, min};
    const PairLanes3 back = {hn::Neg(axis.x), hn::Neg(axis.y), hn::Neg(axis.z)};
    for (int c = 0; c < kControlPoints; ++c) {
      PairLanes3 a, b;
      const PairLanes low = lowest(axis, 1, c, lane, b), minus_high = lowest(back, 0, c, lane, a);
      const PairLanes found = hn::Add(low, minus_high);
      const PairMask nearer = hn::Lt(found, min);
      min = hn::IfThenElse(nearer, found, min);
      difference = select(nearer, sub(b, a), difference);
    }
    return min;
  }

 private:
  static constexpr std::size_t kPairs = PairList::kPairs;
  static constexpr std::size_t kExtent = 0, kTotal = 1, kPoints = 2;  ///< indices of triples of rows

  HWY_INLINE const double* at(Index v) const { return points_ + std::size_t{v} * (3 * kControlPoints); }
  HWY_INLINE PairLanes3 load(std::size_t side, std::size_t triple, std::size_t lane) const {
    return load3(PairTag(), rows_ + ((side * kTriples + triple) * 3) * kPairs + lane, kPairs);
  }
  HWY_INLINE PairLanes3 point(std::size_t side, std::size_t v, int c, std::size_t lane) const {
    return load(side, kPoints + v * kControlPoints + static_cast<std::size_t>(c), lane);
  }
  HWY_INLINE void store(const PairLanes3& x, std::size_t side, std::size_t triple, std::size_t lane) {
    float* to = rows_ + ((side * kTriples + triple) * 3) * kPairs + lane;
    hn::Store(x.x, PairTag(), to);
    hn::Store(x.y, PairTag(), to + kPairs);
    hn::Store(x.z, PairTag(), to + 2 * kPairs);
  }

  void gather_first(const Index* first, const Index* const* vertices, std::size_t lane) {
    constexpr std::size_t lanes = hn::MaxLanes(PairTag());
    if (std::equal(first, first + lanes, first_ + lane)) return;
    bool one = true;
    for (std::size_t i = 0; i < lanes; ++i) {
      one = one && first[i] == first[0];
      first_[lane + i] = first[i];
      reference_[lane + i] = at(*vertices[i]);
    }
    one ? spread(0, vertices[0], lane) : gather(0, vertices, lane);
  }

  /// Reads the points of one element per lane of a register, given their vertices.
  void gather(std::size_t side, const Index* const* vertices, std::size_t lane) {
    gather(side, lane, [&](std::size_t v, PairLanes3(&x)[kControlPoints]) HWY_ATTR {
      const double* p[kPairs];
      for (std::size_t i = 0; i < hn::Lanes(PairTag()); ++i) p[i] = at(vertices[i][v]);
      for (int c = 0; c < kControlPoints; ++c) x[c] = load_differences<kControlPoints>(p, reference_ + lane, c);
    });
  }

  /// Reads the points of one element into all lanes of the register, if there is only one pair, or all pairs have the
  /// same first element.
  void spread(std::size_t side, const Index* vertices, std::size_t lane) {
    gather(side, lane, [&](std::size_t v, PairLanes3(&x)[kControlPoints]) HWY_ATTR {
      const double *p = at(vertices[v]), *r = reference_[lane];
      const auto difference = [&](int k) HWY_ATTR { return in_lanes(static_cast<float>(p[k] - r[k])); };
      for (int c = 0; c < kControlPoints; ++c) x[c] = {difference(3 * c), difference(3 * c + 1), difference(3 * c + 2)};
    });
  }

  template <class LoadPoints>
  HWY_INLINE void gather(std::size_t side, std::size_t lane, const LoadPoints& load_points) {
    const PairLanes min = in_lanes(kFloatMinExtent), zero = in_lanes(0);
    PairLanes3 extent = {min, min, min}, total = {zero, zero, zero};
    for (std::size_t v = 0; v < count_[side]; ++v) {
      PairLanes3 x[kControlPoints];
      load_points(v, x);
      for (int c = 0; c < kControlPoints; ++c) extent = max(extent, abs(x[c]));
      restrict_to<kControlPoints>(interval_, x);
      for (int c = 0; c < kControlPoints; ++c) {
        total = add(total, x[c]);
        store(x[c], side, kPoints + v * kControlPoints + static_cast<std::size_t>(c), lane);
      }
    }
    store(extent, side, kExtent, lane);
    store(total, side, kTotal, lane);
  }

  /// Smallest projection of the vertices at one control point, and the position of that vertex.
  HWY_INLINE PairLanes lowest(const PairLanes3& axis, std::size_t side, int c, std::size_t lane, PairLanes3& at) const {
    at = point(side, 0, c, lane);
    PairLanes low = dot(axis, at);
    for (std::size_t v = 1; v < count_[side]; ++v) {
      const PairLanes3 x = point(side, v, c, lane);
      const PairLanes projection = dot(axis, x);
      const PairMask lower = hn::Lt(projection, low);
      low = hn::IfThenElse(lower, projection, low);
      at = select(lower, x, at);
    }
    return low;
  }

  static constexpr std::size_t kTriples = kPoints + PairList::kVertices * kControlPoints;

  const StepInterval& interval_;
  const double* points_;
  float separation_;
  std::size_t count_[2] = {};
  Index first_[kPairs];  ///< first elements whose points the lanes hold
  const double* reference_[kPairs];
  alignas(64) float rows_[2 * kTriples * 3 * kPairs];
};

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
