// Feature filter: drops a test if its four points are never coplanar (the non-penetration filter of Tang, Manocha and
// Tong 2010).
#pragma once

#include <volccd/query/roles/feature_filter.hpp>

namespace volccd {

/// If two features touch, their four vertices are coplanar: det(p1 - p0, p2 - p0, p3 - p0)(t) = 0. The filter drops a
/// test if all Bernstein coefficients of this polynomial (degree 3 for two control points, 6 for three) have the same
/// sign.
///
/// With step.separation = d > 0, the determinant is a distance times an area. VF: |det| = |distance of the vertex from
/// the plane of the triangle| |n|. EE: |det| = |distance of the lines of the edges| |ea x eb|. Features within distance
/// d of each other have |det| <= d M, where M is an upper bound of that area over the step. The filter therefore drops
/// a test if all coefficients have the same sign and magnitudes greater than d M.
///
/// Guarantee: conservative in floating point for any finite coordinates: the sign of a coefficient is used only if its
/// magnitude exceeds its rounding bound (numerics/rounding.hpp). For step.t_max < 1 the polynomial is restricted to [0,
/// t_max].
class CoplanarityFilter final : public FeatureFilter {
 public:
  void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block,
           std::span<std::uint8_t> keep) const override;
};

StageDescriptor<FeatureFilter> describe_coplanarity_filter();

}  // namespace volccd
