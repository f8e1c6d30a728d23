// The rounding bounds of the narrow phases are large enough. They are compared with an automatic forward error
// analysis, and tested on quantities that are exactly zero, for which only the bound prevents a wrong sign.
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <boost/multiprecision/gmp.hpp>

#include <volccd/narrowphase/inclusion/detail/motion_piece.hpp>
#include <volccd/narrowphase/inclusion/inclusion.hpp>

#include "narrowphase/query_set.hpp"

namespace volccd::test {
namespace {

using Rational = boost::multiprecision::mpq_rational;

/// A computed quantity: its greatest possible magnitude, and its greatest error to first order, in units of u.
struct Rounded {
  double magnitude = 0, error = 0;

  friend Rounded operator+(Rounded a, Rounded b) {
    const double m = a.magnitude + b.magnitude;
    return {m, a.error + b.error + m};
  }
  friend Rounded operator-(Rounded a, Rounded b) { return a + b; }
  friend Rounded operator*(Rounded a, Rounded b) {
    const double m = a.magnitude * b.magnitude;
    return {m, a.error * b.magnitude + b.error * a.magnitude + m};
  }
};

Rounded exactly(double x) { return {std::abs(x), 0}; }
/// A product with a power of two is not rounded.
Rounded scaled(Rounded a, double power) { return {power * a.magnitude, power * a.error}; }

/// fl(1 - t) a + t b for the worst t. This is a convex combination, so that the magnitude does not grow.
Rounded between(Rounded a, Rounded b) {
  Rounded worst;
  for (int i = 0; i <= 16; ++i) {
    const double t = i / 16.0;
    const Rounded r = {1 - t, 1 - t};
    const Rounded sum = r * a + exactly(t) * b;
    worst = {std::max(worst.magnitude, sum.magnitude), std::max(worst.error, sum.error)};
  }
  return worst;
}

/// A coordinate of a difference of two points after this number of levels of de Casteljau's scheme; its extent is 1.
Rounded coordinate(int levels) {
  Rounded x = {1, 1};
  for (int i = 0; i < levels; ++i) x = between(x, x);
  return x;
}

Rounded dot(Rounded a, Rounded b) { return a * b + a * b + a * b; }
Rounded cross(Rounded a, Rounded b) { return a * b - a * b; }

double binomial(int n, int k) { return detail::binomial(n, k); }

TEST(RoundingBounds, GapAlongAnAxis) {
  for (int levels = 0; levels <= 2; ++levels) {
    const Rounded p = dot(exactly(1), coordinate(levels));
    EXPECT_GE(gap_error_factor(levels) / kUnitRoundoff, 2 * p.error / p.magnitude) << levels;
  }
}

/// As in MotionPiece::separated_along_curve, divided by binomials.
TEST(RoundingBounds, GapAlongACurve) {
  for (int n = 1; n <= 2; ++n) {
    std::vector<Rounded> q(5);
    const auto add = [](Rounded& sum, Rounded term) { sum = sum.magnitude == 0 ? term : sum + term; };
    for (int i = 0; i <= 2; ++i)
      for (int c = 0; c <= n; ++c)
        add(q[static_cast<std::size_t>(i + c)],
            scaled(dot(exactly(1), coordinate(n)), binomial(2, i) * binomial(n, c)));
    if (n == 1)
      for (std::size_t k = 4; k > 0; --k) add(q[k], q[k - 1]);
    for (int k = 0; k <= 4; ++k)
      EXPECT_GE(detail::curve_error_factor(n) / kUnitRoundoff,
                2 * q[static_cast<std::size_t>(k)].error / (3 * binomial(4, k)))
          << n << k;
  }
}

/// For curves with coordinates of at most 1, as in MotionPiece::separated_along_curve. The factor holds for squares of
/// the length, 3, in place of that of one coordinate.
TEST(RoundingBounds, LengthOfACurve) {
  const Rounded square = dot(exactly(1), exactly(1)), sum = scaled(square, 2) + scaled(square, 4);
  for (const auto& [q, weight] : {std::pair{square, 1.0}, {scaled(square, 4), 4.0}, {sum, 6.0}}) {
    const Rounded most = q + exactly(weight) * (exactly(1) + exactly(0));
    const Rounded bound = exactly(1) * most;
    EXPECT_GE(detail::kCurveLengthError / kUnitRoundoff, bound.error / (weight * (1 + 3))) << weight;
  }
}

TEST(RoundingBounds, SumsOfThreeCoordinates) {
  for (int levels = 0; levels <= 2; ++levels) {
    Rounded x = exactly(1);  // a coordinate itself
    for (int i = 0; i < levels; ++i) x = between(x, x);
    const Rounded sum = x + x + x;
    EXPECT_GE(sum_error_factor(levels) / kUnitRoundoff, 2 * sum.error / sum.magnitude) << levels;
  }
}

/// As in MotionPiece::prove_never_coplanar: normals, then their products with the first difference, divided by binomial
/// * permanent.
TEST(RoundingBounds, CoplanarityCoefficients) {
  for (const int points : {2, 3})
    for (int levels = 0; levels < points; ++levels) {
      const int n = points - 1;
      const Rounded e = coordinate(levels);
      std::vector<Rounded> normal(static_cast<std::size_t>(2 * n + 1)), b(static_cast<std::size_t>(3 * n + 1));
      const auto add = [](Rounded& sum, Rounded term) { sum = sum.magnitude == 0 ? term : sum + term; };
      for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j)
          add(normal[static_cast<std::size_t>(i + j)], scaled(cross(e, e), binomial(n, i) * binomial(n, j)));
      for (int i = 0; i <= n; ++i)
        for (int k = 0; k <= 2 * n; ++k)
          add(b[static_cast<std::size_t>(i + k)], scaled(dot(e, normal[static_cast<std::size_t>(k)]), binomial(n, i)));
      for (int k = 0; k <= 3 * n; ++k)
        EXPECT_GE(determinant_error_factor(points, levels) / kUnitRoundoff,
                  b[static_cast<std::size_t>(k)].error / (6 * binomial(3 * n, k)))
            << points << " points, " << levels << " levels, coefficient " << k;
    }
}

TEST(RoundingBounds, CoefficientsOfOverlaps) {
  for (int n = 1; n <= 2; ++n) {
    const Rounded e = coordinate(n);
    std::vector<Rounded> q(static_cast<std::size_t>(2 * n + 1));
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= n; ++j) {
        Rounded& sum = q[static_cast<std::size_t>(i + j)];
        const Rounded term = scaled(dot(exactly(1), cross(e, e)), binomial(n, i) * binomial(n, j));
        sum = sum.magnitude == 0 ? term : sum + term;
      }
    for (int k = 0; k <= 2 * n; ++k) {
      const Rounded three =
          q[static_cast<std::size_t>(k)] + q[static_cast<std::size_t>(k)] + q[static_cast<std::size_t>(k)];
      EXPECT_GE(detail::quadric_error_factor(n) / kUnitRoundoff, three.error / (3 * 6 * binomial(2 * n, k))) << n << k;
    }
  }
}

/// Horner's scheme as in MotionPiece::value, and de Casteljau's, on coefficients of magnitude 1.
TEST(RoundingBounds, ValuesFromBernsteinCoefficients) {
  for (const int degree : {3, 6}) {
    double worst = 0;
    for (int i = 0; i <= 64; ++i) {
      const Rounded s = exactly(i / 64.0), r = {1 - i / 64.0, 1 - i / 64.0};
      Rounded sum = exactly(1), power = exactly(1);
      for (int k = 1; k <= degree; ++k) {
        power = power * s;
        sum = sum * r + exactly(binomial(degree, k)) * power;
      }
      worst = std::max(worst, sum.error);
    }
    Rounded value = {1, 2};  // a binomial is divided out: 1 / binomial, and the product
    for (int k = 0; k < degree; ++k) value = between(value, value);
    EXPECT_GE(detail::value_error_factor(degree) / kUnitRoundoff, std::max(worst, value.error)) << degree;
  }
}

TEST(RoundingBounds, LengthsAreNotTooShort) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int i = 0; i < 20000; ++i) {
    const double scale = std::ldexp(1.0, static_cast<int>(random() % 1000) - 500);
    const Vec3 l = scale * Vec3(number(random), number(random), number(random));
    const double separation = std::abs(number(random));
    const Rational gap(separation_gap(separation, l.x(), l.y(), l.z())), d(separation);
    const Rational square =
        Rational(l.x()) * Rational(l.x()) + Rational(l.y()) * Rational(l.y()) + Rational(l.z()) * Rational(l.z());
    ASSERT_GE(gap * gap, d * d * square) << l.transpose() << " separation " << separation;
  }
}

/// The vertex is at the origin. All corners of the triangle have the same x, which grows from `gap` to 1.
template <int kPoints>
bool separated_by(double gap, double lo, double hi) {
  std::array<std::array<Vec3, kPoints>, 4> curves;
  for (std::size_t c = 0; c < kPoints; ++c) {
    curves[0][c].setZero();
    const double x = c == 0 ? gap : 1;
    curves[1][c] = {x, 0, 0};
    curves[2][c] = {x, 1, 0};
    curves[3][c] = {x, 0, 1};
  }
  detail::TestPoints points;
  for (std::size_t i = 0; i < 4; ++i) points[i] = curves[i][0].data();
  const detail::BoundedTest<kPoints> test(FeatureKind::vf, points, 0);
  return detail::MotionPiece<kPoints>(test, lo, hi).separated_along({1, 0, 0});
}

/// Nothing is rounded here, but the bound does not know this.
TEST(RoundingBounds, NoGapBelowTheBoundCounts) {
  const auto bound = [](int levels) {
    const Rounded p = exactly(1) * coordinate(levels);
    return 2 * p.error * kUnitRoundoff;
  };
  EXPECT_FALSE(separated_by<2>(bound(1), 0, 1));
  EXPECT_FALSE(separated_by<3>(bound(2), 0, 1));
  EXPECT_TRUE(separated_by<2>(64 * kUnitRoundoff, 0, 1));
  EXPECT_TRUE(separated_by<3>(64 * kUnitRoundoff, 0, 1));
}

/// Four points whose coplanarity polynomial is exactly zero at t, k / 16 of the step: triangles without relative
/// motion, where all points have the same velocity (and acceleration).
template <int kPoints>
std::vector<Vec3> coplanar_at(std::mt19937_64& random, int sixteenths) {
  const auto integers = [&](int range) {
    std::uniform_int_distribution<int> number(-range, range);
    return Vec3(number(random), number(random), number(random));
  };
  const Vec3 a = integers(1 << 20), e1 = 16 * integers(1 << 16), e2 = 16 * integers(1 << 16),
             drift = 16 * integers(1 << 16);
  std::uniform_int_distribution<int> weight(0, 16);
  const Vec3 in_plane = a + (weight(random) / 16.0) * e1 + (weight(random) / 16.0) * e2,
             velocity = 16 * integers(1 << 16);
  const double t = sixteenths / 16.0;
  std::vector<Vec3> points;
  for (int c = 0; c < kPoints; ++c) {
    // Control points of straight lines, at c / (kPoints - 1) of the motion.
    const double s = double(c) / (kPoints - 1);
    const Vec3 moved = s * drift;
    for (const Vec3& p : {Vec3(in_plane + (s - t) * velocity), a, Vec3(a + e1), Vec3(a + e2)})
      points.push_back(p + moved);
  }
  return points;
}

template <int kPoints>
void expect_no_sign_up_to_a_root(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  for (int i = 0; i < 3000; ++i) {
    const int sixteenths = 1 + static_cast<int>(random() % 15);
    const std::vector<Vec3> x = coplanar_at<kPoints>(random, sixteenths);
    std::array<std::array<Vec3, kPoints>, 4> curves;
    detail::TestPoints points;
    for (std::size_t p = 0; p < 4; ++p) {
      for (std::size_t c = 0; c < kPoints; ++c) curves[p][c] = x[4 * c + p];
      points[p] = curves[p][0].data();
    }
    const detail::BoundedTest<kPoints> test(FeatureKind::vf, points, 0);
    detail::MotionPiece<kPoints> piece(test, 0, 1);
    piece.prove_never_coplanar();
    const double t = sixteenths / 16.0;
    ASSERT_FALSE(piece.never_coplanar_before(t)) << i;
    ASSERT_FALSE(piece.never_coplanar_after(t)) << i;
  }
}

TEST(RoundingBounds, NoOneSignUpToARoot) {
  expect_no_sign_up_to_a_root<2>(1);
  expect_no_sign_up_to_a_root<3>(2);
}

/// A vertex moves exactly along the normal through a side of a triangle (an edge through an end of another edge). The
/// planes across that side, which could show that it passes beside it, have no gap.
Query through_the_border(std::mt19937_64& random, FeatureKind kind) {
  std::uniform_int_distribution<int> number(-1'000'000, 1'000'000), weight(0, 16), power(-40, -10);
  const auto vector = [&] { return Vec3(number(random), number(random), number(random)); };
  const Vec3 a = 16 * vector(), e1 = 16 * vector(), e2 = 16 * vector();
  const Vec3 n = std::ldexp(1.0, power(random)) * e1.cross(e2).array().round().matrix();
  const Vec3 step = n.array().round();  // so that all following values are integers below 2^53
  const Vec3 touch = a + (weight(random) / 16.0) * e1;
  const Vec3 start = touch + step, end = touch - (1 + int(random() % 3)) * step;
  if (kind == FeatureKind::vf) return {start, a, a + e1, a + e2, end, a, a + e1, a + e2};
  return {start, start + e2, a, a + e1, end, end + e2, a, a + e1};
}

TEST(RoundingBounds, ContactsOnTheBorderAreNotLost) {
  for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee}) {
    std::mt19937_64 random(11);
    std::vector<Query> queries(4000);
    for (Query& query : queries) query = through_the_border(random, kind);
    const QuerySet set(kind, queries);
    EXPECT_EQ(set.test(Inclusion()).size(), queries.size());
  }
}

}  // namespace
}  // namespace volccd::test
