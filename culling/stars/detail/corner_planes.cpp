#include <volccd/culling/stars/detail/corner_planes.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Geometry>

#include <volccd/numerics/gjk_simplex.hpp>
#include <volccd/numerics/rounding.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/culling/stars/detail/corner_planes.cpp"
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

/// A bound on the errors of dot products: the sum of factor[k] |x[k]|, plus `least`.
struct ProductBound {
  double factor[3], min;
};
constexpr double kMinProduct = 0x1p-1000;  ///< more than what underflows in a dot product

/// Whether the dot products of all vectors with the direction are certainly positive.
HWY_INLINE bool all_positive(const CornerVectors& corner, const double* direction, const ProductBound& error) {
  const CornerTag tag;
  for (std::size_t lane = 0; lane < CornerVectors::kLanes; lane += hn::Lanes(tag)) {
    const auto term = [&](std::size_t k) HWY_ATTR {
      return hn::Mul(hn::Set(tag, error.factor[k]), hn::Abs(hn::Load(tag, corner.x[k] + lane)));
    };
    const CornerLanes bound = hn::Add(hn::Add(term(0), term(1)), hn::Add(term(2), hn::Set(tag, error.min)));
    if (!hn::AllTrue(tag, hn::Gt(products(corner, direction, lane), bound))) return false;
  }
  return true;
}

/// Approaches the point nearest to the origin of the convex hull of the vectors of b and of the negated ones of a,
/// beginning with any direction. Returns true as soon as certain(direction).
template <class Certain>
HWY_INLINE bool find_direction(const CornerVectors& a, const CornerVectors& b, Vec3 direction, Certain&& certain) {
  constexpr int kMaxRounds = 8;
  GjkSimplex simplex;
  for (int round = 0; round < kMaxRounds; ++round) {
    const LowestVector in_a = lowest(a, Vec3(-direction).data()), in_b = lowest(b, direction.data());
    if (in_a.product > 0 && in_b.product > 0 && certain(direction)) return true;
    const Vec3 next = in_b.product < in_a.product ? b.at(in_b.place) : Vec3(-a.at(in_a.place));
    if (simplex.contains(next)) return false;
    simplex.add(next);
    if (!simplex.reduce(direction)) return false;
  }
  return false;
}

/// The difference of the means, a direction for most pairs.
HWY_INLINE Vec3 between_means(const CornerVectors& a, const CornerVectors& b) {
  return Vec3(b.sum[0], b.sum[1], b.sum[2]) / static_cast<double>(b.size) -
         Vec3(a.sum[0], a.sum[1], a.sum[2]) / static_cast<double>(a.size);
}

/// Each dot product has a rounded difference, a product and two sums. A vector is changed by up to the separation.
HWY_INLINE bool separated(const CornerVectors& a, const CornerVectors& b, double separation) {
  return find_direction(a, b, between_means(a, b), [&](const Vec3& direction) HWY_ATTR {
    ProductBound error;
    for (int k = 0; k < 3; ++k) error.factor[k] = 8 * kUnitRoundoff * std::abs(direction[k]);
    error.min = kMinProduct + separation_gap(separation, direction[0], direction[1], direction[2]);
    return all_positive(a, Vec3(-direction).data(), error) && all_positive(b, direction.data(), error);
  });
}

/// The corner without the vectors to one vertex: in their place are those to another one.
HWY_INLINE CornerVectors without(const CornerVectors& corner, std::size_t lane, std::size_t points) {
  CornerVectors rest = corner;
  const std::size_t from = lane == 0 ? points : 0;
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t c = 0; c < points; ++c) {
      for (std::size_t i = lane + c; i < CornerVectors::kLanes; i += corner.size) rest.x[k][i] = corner.x[k][from + c];
      rest.sum[k] -= corner.x[k][lane + c];
    }
  rest.size -= points;
  return rest;
}

/// The vectors without their components along a unit vector.
HWY_INLINE CornerVectors across(const CornerVectors& corner, const double* unit) {
  CornerVectors flat = corner;
  const CornerTag tag;
  for (std::size_t lane = 0; lane < CornerVectors::kLanes; lane += hn::Lanes(tag)) {
    const CornerLanes along = products(corner, unit, lane);
    for (std::size_t k = 0; k < 3; ++k)
      hn::Store(hn::Sub(hn::Load(tag, corner.x[k] + lane), hn::Mul(along, hn::Set(tag, unit[k]))), tag,
                flat.x[k] + lane);
  }
  return flat;
}

/// The normal edge x way of a plane that contains both, and a bound on the error of its dot products with vectors x:
/// each term edge[i] way[j] x[k] has two rounded differences, two products and three sums. If edge and x change by up
/// to d, the product changes by up to d |normal| + d |way| (|x| + d), for the normal without rounding errors.
HWY_INLINE ProductBound plane_normal(const Vec3& edge, const Vec3& way, double separation, Vec3& normal) {
  ProductBound error;
  const double turn = separation_gap(separation, way[0], way[1], way[2]);
  double rounding = 0;
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    normal[k] = edge[i] * way[j] - edge[j] * way[i];
    const double of_normal = 16 * kUnitRoundoff * (std::abs(edge[i] * way[j]) + std::abs(edge[j] * way[i]));
    error.factor[k] = of_normal + turn * kAreaSlack + kMinProduct;
    rounding += of_normal;
  }
  error.min = kMinProduct + separation_gap(separation, normal[0], normal[1], normal[2]) +
              separation * (rounding + turn * kAreaSlack);
  return error;
}

/// The vectors to the common edge's other vertex are in the lanes `edge` and the following of corner a.
HWY_INLINE bool separated_at_edge(const CornerVectors& a, const CornerVectors& b, const CornerPair& pair,
                                  std::size_t points, double separation) {
  const CornerVectors rest_a = without(a, pair.edge_a, points), rest_b = without(b, pair.edge_b, points);
  const auto edge = [&](std::size_t c) { return a.at(pair.edge_a + c); };
  Vec3 unit = edge(0);
  for (std::size_t c = 1; c < points; ++c) unit += edge(c);
  const double length = unit.norm();
  if (!(length > 0)) return false;
  unit /= length;
  const auto certain = [&](const Vec3& direction) HWY_ATTR {
    const Vec3 way = direction.cross(unit);
    for (std::size_t c = 0; c < points; ++c) {
      Vec3 normal;
      const ProductBound error = plane_normal(edge(c), way, separation, normal);
      if (!all_positive(rest_a, Vec3(-normal).data(), error) || !all_positive(rest_b, normal.data(), error))
        return false;
    }
    return true;
  };
  Vec3 start = between_means(rest_a, rest_b);
  if (certain(start)) return true;
  start -= start.dot(unit) * unit;
  return find_direction(across(rest_a, unit.data()), across(rest_b, unit.data()), start, certain);
}

/// Sets apart[n] to 1 if the elements of pairs[n] are proven to be apart, otherwise to 0.
void separate(std::span<const CornerVectors> corners, int control_points, double separation,
              std::span<const CornerPair> pairs, std::uint8_t* apart) {
  for (std::size_t n = 0; n < pairs.size(); ++n) {
    const CornerVectors &a = corners[pairs[n].a], &b = corners[pairs[n].b];
    const bool found = pairs[n].edge_a == CornerPair::kNoEdge
                           ? separated(a, b, separation)
                           : separated_at_edge(a, b, pairs[n], static_cast<std::size_t>(control_points), separation);
    apart[n] = found ? 1 : 0;
  }
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd::detail {

HWY_EXPORT(separate);

CornerVectors::CornerVectors(const Motion& motion, std::span<const Index> vertices, Index corner) {
  if (!fit(motion, vertices)) return;
  const auto coordinates = 3 * static_cast<std::size_t>(motion.control_points());
  const double* const at = motion.at(corner);
  size = 0;
  sum[0] = sum[1] = sum[2] = 0;
  for (const Index v : vertices) {
    if (v == corner) continue;
    const double* const from = motion.at(v);
    for (std::size_t i = 0; i < coordinates; i += 3, ++size)
      for (std::size_t k = 0; k < 3; ++k) sum[k] += x[k][size] = from[i + k] - at[i + k];
  }
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t i = size; i < kLanes; ++i) x[k][i] = x[k][i - size];
}

bool CornerPairs::add(const Step& step, Index v, std::size_t i, std::size_t j, Index other) {
  const std::span<const Index> star = step.features().vertex_elements(v);
  const std::span<const Index> a = step.mesh().vertices(star[i]), b = step.mesh().vertices(star[j]);
  if (i > 0xffff || j > 0xffff || !CornerVectors::fit(step.motion, a) || !CornerVectors::fit(step.motion, b))
    return false;
  const auto lane = [&](std::span<const Index> vertices) {
    if (other == kNone) return CornerPair::kNoEdge;
    const auto at = std::find(vertices.begin(), vertices.end(), other);
    const std::ptrdiff_t place = at - vertices.begin() - std::count(vertices.begin(), at, v);
    return static_cast<std::uint16_t>(place * step.motion.control_points());
  };
  pairs_.push_back({static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(j), lane(a), lane(b)});
  return true;
}

void CornerPairs::decide(const Step& step, Index v, std::vector<ElementPair>& found) {
  if (pairs_.empty()) return;
  const std::span<const Index> star = step.features().vertex_elements(v);
  corners_.clear();
  for (const Index o : star) corners_.emplace_back(step.motion, step.mesh().vertices(o), v);
  apart_.resize(pairs_.size());
  HWY_DYNAMIC_DISPATCH(separate)(corners_, step.motion.control_points(), step.separation, pairs_, apart_.data());
  for (std::size_t n = 0; n < pairs_.size(); ++n)
    if (apart_[n] == 0) found.push_back({star[pairs_[n].a], star[pairs_[n].b]});
}

}  // namespace volccd::detail
#endif
