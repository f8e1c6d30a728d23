#include <volccd/oracle/cases/known_misses.hpp>

#include <volccd/oracle/cases/attack_cases.hpp>

namespace volccd::cases {

namespace {

using TwoPoints = std::array<Vec3, 2>;

Case linear(FeatureKind kind, const std::vector<TwoPoints>& points) {
  Case c;
  c.kind = kind;
  for (std::size_t i = 0; i < points.size(); ++i)
    c.sets[i < c.own(0) ? 0 : 1].push_back({points[i][0], points[i][1], points[i][1]});
  return c;
}

}  // namespace

std::vector<KnownMiss> known_misses() {
  std::vector<KnownMiss> all;

  // The Newton step from the likely root left the part of the step. Contacts were missed if the step was too long, and
  // early if it was too short.
  for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee}) {
    all.push_back({"a skewed curve, missed",
                   crossing_frame(kind, 3, {.069, .0161, 1.13}, {.499, .00357, .00285}, {-11, .0785, .064})});
    all.push_back(
        {"a skewed curve, early", crossing_frame(kind, 3, {.0057, .0069, .66}, {1.7, .28, .12}, {-.034, -.042, 5.8})});
  }

  // A coordinate difference is infinite at both ends; the difference of the two is NaN.
  constexpr double m = 1.7e308;
  const TwoPoints left = {Vec3(-m, 0, 0), Vec3(-m, 0, 0)}, right = {Vec3(m, 0, 0), Vec3(0, 0, 0)};
  const TwoPoints below = {Vec3(.9 * m, -1, 0), Vec3(.9 * m, -1, 0)};
  const TwoPoints above = {Vec3(.9 * m, 1, 0), Vec3(.9 * m, 1, 0)};
  const TwoPoints left_back = {left[1], left[0]}, right_back = {right[1], right[0]};
  const TwoPoints vertex = {Vec3(.9 * m, 0, 0), Vec3(.9 * m, 0, 0)}, corner = {Vec3(0, 1, 0), Vec3(0, 1, 0)};
  const char* const overflow = "differences that overflow";
  all.push_back({overflow, linear(FeatureKind::ee, {left, right, below, above})});
  all.push_back({overflow, linear(FeatureKind::ee, {below, above, left, right})});
  all.push_back({overflow, linear(FeatureKind::ee, {right, left, below, above})});
  all.push_back({overflow, linear(FeatureKind::ee, {left_back, right_back, below, above})});
  all.push_back({overflow, linear(FeatureKind::vf, {vertex, left, right, corner})});

  // The contact was reported at a distance of 2^-39 of the size; the triangle is nearly an edge.
  const TwoPoints sliver = {Vec3(-0x1.5p-447, 0x1.ep-448, 0x1.8p-448),
                            Vec3(-0x1.f6202p-432, 0x1.7f6f3p-431, -0x1.983bcp-431)};
  all.push_back(
      {"near a sliver",
       linear(
           FeatureKind::vf,
           {{Vec3(-0x1.3p-447, 0x1.1p-447, 0x1p-449), Vec3(-0x1.f620ep-432, 0x1.7f6edp-431, -0x1.983a4p-431)},
            {Vec3(-0x1.dp-447, 0x1.cp-449, 0x1p-448), Vec3(-0x1.f6202p-432, 0x1.7f6f300000002p-431, -0x1.983bcp-431)},
            sliver,
            sliver})});

  // Differences are one or two units of the smallest double. All such tests are reported, near or not.
  constexpr double u = 0x1p-1074;
  const auto at = [](double x, double y) { return TwoPoints{Vec3(x, y, 0), Vec3(x, y, 0)}; };
  all.push_back(
      {"differences of the smallest double", linear(FeatureKind::vf, {at(0, 0), at(-u, u), at(0, u), at(-u, -u)})});
  return all;
}

}  // namespace volccd::cases
