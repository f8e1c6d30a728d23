// Feature filter: four points that are never coplanar are no contact (Tang, Manocha, Tong 2010, the non-penetration
// filter).
#pragma once

#include <volccd/culling/feature_filter.hpp>

namespace volccd {

/// Features that touch have coplanar vertices: det(p1 - p0, p2 - p0, p3 - p0)(t) = 0. Drops a test when the Bernstein
/// coefficients of this polynomial (degree 3 for two control points, 6 for three) have one sign.
///
/// With step.separation = d > 0: the determinant is a distance times an area. VF: |det| = |distance of the vertex from
/// the triangle's plane| |n|; EE: |det| = |distance of the edges' lines| |ea x eb|. Features within d of each other
/// have |det| <= d M, with M a bound of that area over the step, so coefficients of one sign beyond d M still drop the
/// test.
///
/// Guarantee: conservative in floating point for any finite coordinates: a coefficient's sign counts beyond its
/// rounding bound only (query/rounding.hpp). For step.t_max < 1 the polynomial over [0, t_max] is taken.
class CoplanarityFilter final : public FeatureFilter {
 public:
  struct Config {};
  static const Options<Config>& options();

  explicit CoplanarityFilter(const Config&) {}

  void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block,
           std::span<std::uint8_t> keep) const override;
};

StageDescriptor<FeatureFilter> describe_coplanarity_filter();

}  // namespace volccd
