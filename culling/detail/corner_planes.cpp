#include <volccd/culling/detail/corner_planes.hpp>

#include <algorithm>

#include <volccd/query/rounding.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/culling/detail/corner_planes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using CornerTag = hn::CappedTag<double, 8>;
using CornerLanes = hn::Vec<CornerTag>;

/// A dot product of all vectors of a corner, as the least one and its place.
struct LowestVector {
  double product;
  std::size_t place;
};

HWY_INLINE CornerLanes products(const CornerVectors& corner, const double* direction, std::size_t lane) {
  const CornerTag tag;
  const auto term = [&](std::size_t k)
                        HWY_ATTR { return hn::Mul(hn::Set(tag, direction[k]), hn::Load(tag, corner.x[k] + lane)); };
  return hn::Add(hn::Add(term(0), term(1)), term(2));
}

HWY_INLINE LowestVector lowest(const CornerVectors& corner, const double* direction) {
  const CornerTag tag;
  alignas(64) double all[CornerVectors::kLanes];
  for (std::size_t lane = 0; lane < CornerVectors::kLanes; lane += hn::Lanes(tag))
    hn::Store(products(corner, direction, lane), tag, all + lane);
  LowestVector found{all[0], 0};
  for (std::size_t i = 1; i < CornerVectors::kLanes; ++i)
    if (all[i] < found.product) found = {all[i], i};
  return found;
}

/// Whether the products of all vectors are certainly positive, also if the vectors are changed by up to the separation.
/// Each has a rounded difference, a product and two sums.
HWY_INLINE bool all_positive(const CornerVectors& corner, const double* direction, double separation) {
  constexpr double kUnderflow = 0x1p-1000;  // more than what underflows in a dot product
  const double least = kUnderflow + separation_gap(separation, direction[0], direction[1], direction[2]);
  const CornerTag tag;
  for (std::size_t lane = 0; lane < CornerVectors::kLanes; lane += hn::Lanes(tag)) {
    const auto magnitude = [&](std::size_t k) HWY_ATTR {
      return hn::Abs(hn::Mul(hn::Set(tag, direction[k]), hn::Load(tag, corner.x[k] + lane)));
    };
    const CornerLanes sum = hn::Add(hn::Add(magnitude(0), magnitude(1)), magnitude(2));
    const CornerLanes bound = hn::Add(hn::Mul(sum, hn::Set(tag, 8 * kUnitRoundoff)), hn::Set(tag, least));
    if (!hn::AllTrue(tag, hn::Gt(products(corner, direction, lane), bound))) return false;
  }
  return true;
}

HWY_INLINE bool separated(const CornerVectors& a, const CornerVectors& b, double separation) {
  constexpr int kMostRounds = 6;
  double direction[3], back[3];
  for (std::size_t k = 0; k < 3; ++k) {
    direction[k] = 0;
    for (std::size_t i = 0; i < CornerVectors::kLanes; ++i) direction[k] += b.x[k][i] - a.x[k][i];
    direction[k] *= 0.5 / CornerVectors::kLanes;
  }
  for (int round = 0; round < kMostRounds; ++round) {
    for (std::size_t k = 0; k < 3; ++k) back[k] = -direction[k];
    const LowestVector in_a = lowest(a, back), in_b = lowest(b, direction);
    if (in_a.product > 0 && in_b.product > 0 && all_positive(a, back, separation) &&
        all_positive(b, direction, separation))
      return true;
    const bool from_b = in_b.product < in_a.product;
    double along = 0, square = 0, way[3];
    for (std::size_t k = 0; k < 3; ++k) {
      way[k] = (from_b ? b.x[k][in_b.place] : -a.x[k][in_a.place]) - direction[k];
      along -= direction[k] * way[k];
      square += way[k] * way[k];
    }
    const double share = along / square;
    if (!(share > 0)) return false;
    for (std::size_t k = 0; k < 3; ++k) direction[k] += std::min(share, 1.0) * way[k];
  }
  return false;
}

void separate(std::span<const CornerVectors> corners, double separation,
              std::span<const std::array<std::uint16_t, 2>> pairs, std::uint8_t* apart) {
  for (std::size_t n = 0; n < pairs.size(); ++n)
    apart[n] = separated(corners[pairs[n][0]], corners[pairs[n][1]], separation) ? 1 : 0;
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd::detail {

HWY_EXPORT(separate);

CornerVectors::CornerVectors(const Motion& motion, std::span<const Index> vertices, Index corner) {
  if (!fit(motion, vertices)) return;
  const auto points = static_cast<std::size_t>(motion.control_points());
  const double* const at = motion.at(corner);
  std::size_t size = 0;
  for (const Index v : vertices) {
    if (v == corner) continue;
    for (std::size_t c = 0; c < points; ++c, ++size)
      for (std::size_t k = 0; k < 3; ++k) x[k][size] = motion.at(v)[3 * c + k] - at[3 * c + k];
  }
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t i = size; i < kLanes; ++i) x[k][i] = x[k][i - size];
}

void separate_corners(std::span<const CornerVectors> corners, double separation,
                      std::span<const std::array<std::uint16_t, 2>> pairs, std::uint8_t* apart) {
  HWY_DYNAMIC_DISPATCH(separate)(corners, separation, pairs, apart);
}

}  // namespace volccd::detail
#endif
