// Overlap of convex hulls in exact arithmetic, compared with the theorem of Caratheodory.
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/narrowphase/exact/exact_predicates.hpp>

namespace volccd {
namespace {

/// Whether 0 is in the hull of `points`, that is, in the hull of at most four of them that span it (Caratheodory). For
/// small integers.
bool contains_origin(const std::vector<Vec3>& points) {
  const auto in_triangle = [](const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 n = (b - a).cross(c - a);
    return n.squaredNorm() > 0 && n.dot(a) == 0 && n.dot(a.cross(b)) >= 0 && n.dot(b.cross(c)) >= 0 &&
           n.dot(c.cross(a)) >= 0;
  };
  const auto volume = [](const Vec3& a, const Vec3& b, const Vec3& c) { return a.dot(b.cross(c)); };
  const std::size_t n = points.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i; j < n; ++j) {
      const Vec3 &a = points[i], &b = points[j];
      if (a.cross(b).isZero(0) && a.dot(b) <= 0) return true;
      for (std::size_t k = j + 1; k < n; ++k) {
        const Vec3& c = points[k];
        if (in_triangle(a, b, c)) return true;
        for (std::size_t l = k + 1; l < n; ++l) {
          const Vec3& d = points[l];
          const double whole = volume(b - a, c - a, d - a);
          if (whole != 0 && whole * volume(b, c, d) >= 0 && whole * volume(a, d, c) >= 0 &&
              whole * volume(a, b, d) >= 0 && whole * volume(a, c, b) >= 0)
            return true;
        }
      }
    }
  return false;
}

TEST(ExactHulls, AgreesWithCaratheodory) {
  Random random(6);
  int overlaps = 0;
  for (int i = 0; i < 4000; ++i) {
    const std::uint64_t range = 2 + random.below(8);
    const auto points = [&] {
      std::vector<Vec3> x(1 + random.below(4));
      for (Vec3& p : x)
        for (Eigen::Index k = 0; k < 3; ++k) p[k] = static_cast<double>(random.below(range));
      return x;
    };
    std::vector<Vec3> a = points(), b = points(), differences;
    for (const Vec3& p : a)
      for (const Vec3& q : b) differences.push_back(p - q);
    const bool expected = contains_origin(differences);
    overlaps += expected;
    ASSERT_EQ(exact_hulls_overlap(a, b), expected) << i;
    ASSERT_EQ(exact_hulls_overlap(b, a), expected) << i;
    for (std::vector<Vec3>* x : {&a, &b})
      for (Vec3& p : *x) p = p * 0x1p-1074;
    ASSERT_EQ(exact_hulls_overlap(a, b), expected) << i;
  }
  EXPECT_GT(overlaps, 400);
  EXPECT_LT(overlaps, 3600);
}

TEST(ExactHulls, Hexahedra) {
  const auto box = [](const Vec3& low, double size) {
    std::vector<Vec3> x;
    for (int i = 0; i < 8; ++i) x.push_back(low + size * Vec3(i & 1, i >> 1 & 1, i >> 2));
    return x;
  };
  const std::vector<Vec3> unit = box({0, 0, 0}, 1);
  EXPECT_TRUE(exact_hulls_overlap(unit, box({.25, .25, .25}, .5)));
  EXPECT_TRUE(exact_hulls_overlap(unit, box({1, 1, 1}, 1)));
  // The first point is an ulp beyond the corner (1,1,1) of the box, so that the hulls do not overlap.
  const std::vector<Vec3> tip = {{1 + 0x1p-52, 1, 1}, {3, 0, 1}, {3, 2, 0}, {0, 3, 3}};
  EXPECT_FALSE(exact_hulls_overlap(unit, tip));
  EXPECT_TRUE(exact_hulls_overlap(unit, std::vector<Vec3>{{1, 1, 1}, {3, 0, 1}, {3, 2, 0}, {0, 3, 3}}));
  EXPECT_FALSE(exact_hulls_overlap(unit, {}));
}

}  // namespace
}  // namespace volccd
