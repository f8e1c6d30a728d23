// The search of `inclusion` for tests with a separation: what it decides, and that an axis that turns separates only
// features that are further apart than the separation.
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <boost/multiprecision/gmp.hpp>

#include <volccd/narrowphase/exact/exact_predicates.hpp>
#include <volccd/narrowphase/inclusion/detail/inclusion_search.hpp>
#include <volccd/narrowphase/inclusion/detail/motion_piece.hpp>

namespace volccd::test {
namespace {

using detail::InclusionAnswer;
using Outcome = InclusionAnswer::Outcome;
using Rational = boost::multiprecision::mpq_rational;

/// Control points of the four points of a test.
template <int kPoints>
using Curves = std::array<std::array<Vec3, kPoints>, 4>;

template <int kPoints>
detail::TestPoints points_of(const Curves<kPoints>& curves) {
  detail::TestPoints points;
  for (std::size_t i = 0; i < 4; ++i) points[i] = curves[i][0].data();
  return points;
}

Vec3 random_vector(std::mt19937_64& random) {
  std::uniform_real_distribution<double> number(-1, 1);
  const double x = number(random), y = number(random);
  return {x, y, number(random)};
}

/// Two features of size 1 face each other at this distance; the closest points are inside both of them.
std::array<Vec3, 4> facing(FeatureKind kind, double distance) {
  if (kind == FeatureKind::vf) return {Vec3(0, 0, distance), Vec3(-0.4, -0.3, 0), Vec3(0.5, -0.2, 0), Vec3(0, 0.6, 0)};
  return {Vec3(-0.5, 0, distance), Vec3(0.4, 0, distance), Vec3(0, -0.4, 0), Vec3(0, 0.5, 0)};
}

/// The features move together: they turn by an angle, and keep the distance at the control points.
template <int kPoints>
Curves<kPoints> turning(FeatureKind kind, double distance, double angle, std::mt19937_64& random) {
  const std::array<Vec3, 4> points = facing(kind, distance);
  const Vec3 axis = random_vector(random).normalized(), way = random_vector(random);
  const Eigen::Matrix3d first = Eigen::AngleAxisd(3, random_vector(random).normalized()).toRotationMatrix();
  Curves<kPoints> curves;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t c = 0; c < kPoints; ++c) {
      const double s = static_cast<double>(c) / (kPoints - 1);
      curves[i][c] = Eigen::AngleAxisd(s * angle, axis) * (first * points[i]) + s * s * way;
    }
  return curves;
}

template <int kPoints>
void expect_few_intervals() {
  std::mt19937_64 random(kPoints);
  for (int i = 0; i < 200; ++i) {
    const FeatureKind kind = i % 2 ? FeatureKind::ee : FeatureKind::vf;
    const Curves<kPoints> curves = turning<kPoints>(kind, 0.01001, 0.02, random);
    const auto answer = detail::inclusion_search(kind, points_of<kPoints>(curves), kPoints, 0.01, 1e-9, 2, 1);
    ASSERT_EQ(answer.outcome, Outcome::apart) << i;
  }
}

/// A fixed axis would have to separate them in thousands of intervals: the far ends move by 0.02, and the gap is 1e-5.
TEST(SeparationSearch, FeaturesThatTurnTogetherNeedFewIntervals) {
  expect_few_intervals<2>();
  expect_few_intervals<3>();
}

/// In the time tolerance, the distance changes by little more than the error with which it is known.
TEST(SeparationSearch, SlowApproachesAreDecided) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> part(0.01, 0.99);
  for (int i = 0; i < 400; ++i) {
    const FeatureKind kind = i % 2 ? FeatureKind::ee : FeatureKind::vf;
    const double way = i < 200 ? 2e-5 : std::ldexp(1e-2, -(i % 8)), share = part(random);
    const auto start = facing(kind, 0.01 + share * way), end = facing(kind, 0.01 - (1 - share) * way);
    Curves<2> curves;
    for (std::size_t p = 0; p < 4; ++p) curves[p] = {start[p], end[p]};
    const auto answer = detail::inclusion_search(kind, points_of<2>(curves), 2, 0.01, 1e-9, 100, 1);
    ASSERT_EQ(answer.outcome, Outcome::touch) << i;
    const double toi = exact_first_touch({kind, 2, points_of<2>(curves)}, 1, 0.01).toi;
    ASSERT_LE(answer.toi, toi) << i;
    ASSERT_GE(answer.toi, toi - 1e-9) << i;
  }
}

/// sum of weights * points, exactly.
using RationalVector = std::array<Rational, 3>;
template <class Points>
RationalVector bezier(const Points& points, const Rational& s) {
  RationalVector sum{};
  const int degree = static_cast<int>(points.size()) - 1;
  for (int c = 0; c <= degree; ++c) {
    Rational weight(detail::binomial(degree, c));
    for (int j = 0; j < degree; ++j) weight *= j < c ? s : Rational(1 - s);
    for (std::size_t k = 0; k < 3; ++k)
      sum[k] += weight * Rational(points[static_cast<std::size_t>(c)][static_cast<Eigen::Index>(k)]);
  }
  return sum;
}

/// Whether the second feature is ahead along the curve by more than the separation at local parameter s of [lo, hi].
template <int kPoints>
bool is_ahead(FeatureKind kind, const Curves<kPoints>& curves, const std::array<Vec3, 3>& axis, double separation,
              double lo, double hi, const Rational& s) {
  const RationalVector n = bezier(axis, s);
  const Rational t = Rational(lo) + s * (Rational(hi) - Rational(lo));
  std::array<Rational, 4> along;
  for (std::size_t i = 0; i < 4; ++i) {
    const RationalVector p = bezier(curves[i], t);
    along[i] = n[0] * p[0] + n[1] * p[1] + n[2] * p[2];
  }
  const std::size_t second = kind == FeatureKind::vf ? 1 : 2;
  const Rational gap = *std::min_element(along.begin() + static_cast<std::ptrdiff_t>(second), along.end()) -
                       *std::max_element(along.begin(), along.begin() + static_cast<std::ptrdiff_t>(second));
  const Rational square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
  return gap > 0 && gap * gap > Rational(separation) * Rational(separation) * square;
}

/// The greatest separation for which the curve is a proof, up to a rounding; 0 if there is none.
template <int kPoints>
double provable(FeatureKind kind, const Curves<kPoints>& curves, const std::array<Vec3, 3>& axis, double lo,
                double hi) {
  const auto proves = [&](double separation) {
    const detail::BoundedTest<kPoints> test(kind, points_of<kPoints>(curves), separation);
    return detail::MotionPiece<kPoints>(test, lo, hi).separated_along_curve(axis);
  };
  double least = 0, greatest = 8;
  while (true) {
    const double middle = least + (greatest - least) / 2;
    if (middle == least || middle == greatest) return least;
    (proves(middle) ? least : greatest) = middle;
  }
}

template <int kPoints>
void expect_true_proofs() {
  std::mt19937_64 random(10 + kPoints);
  std::uniform_real_distribution<double> number(0, 1);
  int proofs = 0;
  for (int i = 0; i < 3000; ++i) {
    const FeatureKind kind = i % 2 ? FeatureKind::ee : FeatureKind::vf;
    Curves<kPoints> curves =
        turning<kPoints>(kind, std::ldexp(1.0, -(i % 12)), std::ldexp(number(random), -(i % 5)), random);
    const double lo = i % 3 ? 0.9 * number(random) : 0, hi = i % 3 ? std::min(1.0, lo + 0.1 * number(random)) : 1;
    std::array<Vec3, 3> axis;
    const auto ahead = [&](double t) {
      const detail::BoundedTest<kPoints> test(kind, points_of<kPoints>(curves), 0);
      const detail::Differences d = test.at(t);
      const Vec3 n = detail::separating_axis(kind, d, detail::closest_points(kind, d));
      const Vec3 apart = kind == FeatureKind::vf ? d[0] : Vec3(d[1]);
      return Vec3(n * ((n.dot(apart) < 0 ? -1 : 1) / n.norm()));
    };
    axis = {ahead(lo), ahead((lo + hi) / 2), ahead(hi)};
    axis[1] = 2 * axis[1] - 0.5 * (axis[0] + axis[2]);
    if (i % 7 == 0)
      for (Vec3& n : axis) n *= 0.5 + number(random);
    const double separation = provable<kPoints>(kind, curves, axis, lo, hi);
    if (separation == 0) continue;
    ++proofs;
    for (const int eighths : {0, 1, 4, 7, 8})
      ASSERT_TRUE(is_ahead<kPoints>(kind, curves, axis, separation, lo, hi, Rational(eighths) / 8))
          << i << ", at " << eighths << "/8 of the interval, separation " << separation;
  }
  EXPECT_GT(proofs, 2000);
}

TEST(SeparationSearch, AnAxisThatTurnsProvesNothingFalse) {
  expect_true_proofs<2>();
  expect_true_proofs<3>();
}

}  // namespace
}  // namespace volccd::test
