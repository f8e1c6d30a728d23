// Overlap of convex hulls compared with the simplex method in rationals and with exact distances of features.
#include <volccd/narrowphase/overlap/initial_overlap.hpp>

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <volccd/core/random.hpp>
#include <volccd/narrowphase/exact/exact_predicates.hpp>
#include <volccd/narrowphase/overlap/detail/hull_overlap.hpp>

namespace volccd {
namespace {

struct Hulls {
  std::vector<Vec3> a, b;

  template <class Map>
  Hulls mapped(Map&& map) const {
    Hulls result;
    for (const Vec3& p : a) result.a.push_back(map(p));
    for (const Vec3& p : b) result.b.push_back(map(p));
    return result;
  }
};

Vec3 random_point(Random& random, double size) {
  return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
}

/// Vertices of a tetrahedron, pyramid, wedge or hexahedron of any shape, or of an element with fewer vertices.
int random_count(Random& random) { return std::array{1, 2, 3, 4, 4, 5, 6, 8, 8}[random.below(9)]; }

Hulls clouds(Random& random) {
  Hulls hulls;
  const Vec3 offset = random_point(random, 1.3);
  for (int i = random_count(random); i > 0; --i) hulls.a.push_back(random_point(random, 1));
  for (int i = random_count(random); i > 0; --i) hulls.b.push_back(random_point(random, 0.8) + offset);
  return hulls;
}

/// Coordinates from {0, 1, 2, 3} give flat hulls and points, coincident vertices, and hulls that touch at vertices,
/// edges and faces.
Hulls lattice(Random& random) {
  const auto point = [&] {
    return Vec3(static_cast<double>(random.below(4)), static_cast<double>(random.below(4)),
                static_cast<double>(random.below(4)));
  };
  Hulls hulls;
  const Vec3 offset = point() - Vec3(1, 1, 1);
  for (int i = random_count(random); i > 0; --i) hulls.a.push_back(point());
  for (int i = random_count(random); i > 0; --i) hulls.b.push_back(point() + offset);
  return hulls;
}

/// A vertex of b is at a rational place on a triangle of a (up to rounding, and then an ulp away); the others are
/// beyond its plane.
Hulls barely(Random& random) {
  Hulls hulls;
  for (int i = 0; i < 4; ++i) hulls.a.push_back(random_point(random, 1));
  const double u = std::array{0.0, 0.25, 0.5, 1.0}[random.below(4)],
               v = (1 - u) * std::array{0.0, 0.5, 1.0}[random.below(3)];
  const Vec3 p = hulls.a[0], q = hulls.a[1], r = hulls.a[2];
  Vec3 touching = (1 - u - v) * p + u * q + v * r;
  Vec3 out = (q - p).cross(r - p);
  if (out.dot(hulls.a[3] - p) > 0) out = -out;
  const auto k = static_cast<int>(random.below(3));
  if (const std::uint64_t side = random.below(3); side != 0)
    touching[k] = std::nextafter(touching[k], side == 1 ? -9 : 9);
  hulls.b.push_back(touching);
  for (int i = 0; i < 3; ++i) {
    Vec3 beyond = random_point(random, 1);
    const double height = out.dot(beyond - touching);
    if (height < 0) beyond -= 2 * height / out.squaredNorm() * out;
    hulls.b.push_back(beyond);
  }
  if (random.below(2) == 0) std::swap(hulls.a, hulls.b);
  return hulls;
}

/// One is inside the other, or is thin and pierces it.
Hulls inside(Random& random) {
  Hulls hulls;
  for (int i = 0; i < 8; ++i) hulls.a.push_back(random_point(random, 1));
  const double shrink = std::array{0.0, 1e-9, 0.1}[random.below(3)];
  const Vec3 centre = random_point(random, 0.5);
  for (int i = 0; i < 4; ++i) hulls.b.push_back(centre + shrink * random_point(random, 1));
  hulls.b[3] += random.uniform(0, 4) * random_point(random, 1);
  return hulls;
}

struct Family {
  const char* name;
  std::function<Hulls(Random&)> make;
  int count;
};

/// Compares overlap() and the integer arithmetic with the judge; both answers must occur.
void expect_exact(const Family& family, const std::function<Vec3(const Vec3&)>& map, const std::string& what) {
  Random random(91);
  InitialOverlapTest test;
  int hits = 0;
  for (int i = 0; i < family.count; ++i) {
    const Hulls hulls = family.make(random).mapped(map);
    const bool expected = exact_hulls_overlap(hulls.a, hulls.b);
    hits += expected ? 1 : 0;
    ASSERT_EQ(test.overlap(hulls.a, hulls.b), expected) << family.name << ", " << what << ", " << i;
    ASSERT_EQ(test.overlap(hulls.b, hulls.a), expected) << family.name << ", " << what << ", " << i << " swapped";
    ASSERT_EQ(detail::hulls_in_integers(hulls.a, hulls.b, 0, {}), expected) << family.name << ", " << what << ", " << i;
  }
  EXPECT_GT(hits, family.count / 20) << family.name << ", " << what;
  EXPECT_GT(family.count - hits, family.count / 20) << family.name << ", " << what;
}

TEST(InitialOverlapTest, AgreesWithRationals) {
  const auto as_is = [](const Vec3& p) { return p; };
  for (const Family& family :
       {Family{"clouds", clouds, 600}, {"lattice", lattice, 1500}, {"barely", barely, 1500}, {"inside", inside, 400}})
    expect_exact(family, as_is, "as is");
}

TEST(InitialOverlapTest, AgreesWithRationalsFarOffAndAtAllScales) {
  const auto scaled = [](double factor) { return [factor](const Vec3& p) { return Vec3(factor * p); }; };
  for (const Family& family : {Family{"clouds", clouds, 60}, {"lattice", lattice, 100}, {"barely", barely, 100}}) {
    expect_exact(
        family, [](const Vec3& p) { return Vec3(p + Vec3(1e8, -1e8, 3e7)); }, "offset 1e8");
    for (const double factor : {1e-150, 1e150, 0x1p1020}) expect_exact(family, scaled(factor), std::to_string(factor));
  }
  expect_exact({"lattice", lattice, 100}, scaled(0x1p-1074), "denormal");
  // A rotation rounds, so that faces that touched then overlap, cross, or are apart by an ulp.
  expect_exact(
      {"lattice", lattice, 200},
      [](const Vec3& p) {
        return Vec3(0.6 * p.x() - 0.8 * p.y(), 0.48 * p.x() + 0.36 * p.y() - 0.8 * p.z(),
                    0.64 * p.x() + 0.48 * p.y() + 0.6 * p.z());
      },
      "rotated");
}

/// Closest features of two tetrahedra, each compared exactly: vertices with triangles, and edges with edges.
bool features_within(const Hulls& hulls, double d) {
  const auto close = [&](FeatureKind kind, const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s) {
    std::array<std::array<Vec3, 2>, 4> still = {{{p, p}, {q, q}, {r, r}, {s, s}}};
    return compare_distance({kind, 2, {still[0][0].data(), still[1][0].data(), still[2][0].data(), still[3][0].data()}},
                            0, d) <= 0;
  };
  for (const auto& [x, y] : {std::pair{&hulls.a, &hulls.b}, std::pair{&hulls.b, &hulls.a}})
    for (const Vec3& v : *x)
      for (std::size_t skip = 0; skip < 4; ++skip)
        if (close(FeatureKind::vf, v, (*y)[(skip + 1) % 4], (*y)[(skip + 2) % 4], (*y)[(skip + 3) % 4])) return true;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j)
      for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t l = k + 1; l < 4; ++l)
          if (close(FeatureKind::ee, hulls.a[i], hulls.a[j], hulls.b[k], hulls.b[l])) return true;
  return exact_hulls_overlap(hulls.a, hulls.b);
}

TEST(InitialOverlapTest, SeparationIsExact) {
  Random random(4);
  InitialOverlapTest test;
  int hits = 0, count = 0;
  for (int i = 0; i < 150; ++i) {
    Hulls hulls = i % 3 == 0 ? barely(random) : Hulls{};
    const bool on_lattice = i % 3 == 2;
    while (hulls.a.size() != 4 || hulls.b.size() != 4) hulls = on_lattice ? lattice(random) : clouds(random);
    // Integer distances are frequent on the lattice, so that d = 1 is reached exactly there, and missed by an ulp.
    for (const double d : {on_lattice ? 1.0 : 0.2, on_lattice ? std::nextafter(1.0, 0.0) : 1e-17}) {
      const bool expected = features_within(hulls, d);
      hits += expected ? 1 : 0, ++count;
      ASSERT_EQ(test.overlap(hulls.a, hulls.b, d), expected) << i << " " << d;
      ASSERT_EQ(detail::hulls_in_integers(hulls.a, hulls.b, d, {}), expected) << i << " " << d;
    }
  }
  EXPECT_GT(hits, count / 10);
  EXPECT_GT(count - hits, count / 10);
}

TEST(InitialOverlapTest, DoublesDecideAllButCloseCalls) {
  Random random(8);
  InitialOverlapTest test;
  for (int i = 0; i < 20000; ++i) {
    const Hulls hulls = clouds(random);
    for (const double d : {0.0, 0.3}) {
      const bool found = test.overlap(hulls.a, hulls.b, d);
      if (i % 10 != 0) continue;
      ASSERT_EQ(found, detail::hulls_in_integers(hulls.a, hulls.b, d, {})) << i << " " << d;
    }
  }
  EXPECT_LT(test.close_calls(), 40u) << "of 40000";
}

TEST(InitialOverlapTest, NothingOverlapsAnEmptySet) {
  InitialOverlapTest test;
  EXPECT_FALSE(test.overlap({}, std::vector{Vec3(0, 0, 0)}));
  EXPECT_FALSE(test.overlap(std::vector{Vec3(0, 0, 0)}, {}));
}

TEST(InitialOverlapTest, GreatestAndLeastCoordinatesTogether) {
  constexpr double huge = std::numeric_limits<double>::max(), tiny = 0x1p-1074;
  InitialOverlapTest test;
  const std::vector<Vec3> line = {{-huge, 0, 0}, {huge, 0, 0}};
  EXPECT_TRUE(test.overlap(line, std::vector<Vec3>{{1, -tiny, 0}, {1, tiny, 0}}));
  EXPECT_TRUE(test.overlap(line, std::vector<Vec3>{{0, -1, -tiny}, {tiny, 1, tiny}}));
  EXPECT_FALSE(test.overlap(line, std::vector<Vec3>{{0, -1, tiny}, {tiny, 1, tiny}}));
  EXPECT_FALSE(test.overlap(line, std::vector<Vec3>{{0, -1, 0}, {0, 1, tiny}, {0, 1, 2 * tiny}}, tiny / 2) !=
               exact_hulls_overlap(line, std::vector<Vec3>{{0, -1, 0}, {0, 1, tiny}, {0, 1, 2 * tiny}}));
}

}  // namespace
}  // namespace volccd
