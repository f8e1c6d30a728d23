// Convex pieces, the certificate by separating axes, and the use of FCL.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/oracle/detail/convex_pieces.hpp>
#include <volccd/oracle/detail/fcl_pieces.hpp>
#include <volccd/oracle/detail/separation.hpp>

namespace volccd {
namespace {

using detail::ConvexPiece;
using detail::Cover;

constexpr ElementType kVolumes[] = {ElementType::tetrahedron, ElementType::pyramid, ElementType::wedge,
                                    ElementType::hexahedron, ElementType::polytope};

Vec3 random_point(std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  return {uniform(random), uniform(random), uniform(random)};
}

/// Winding number of the oriented triangles around p: the solid angle they subtend (van Oosterom and Strackee 1983).
int winding_number(const std::vector<std::array<Index, 3>>& triangles, const std::vector<Vec3>& x, const Vec3& p) {
  double angle = 0;
  for (const auto& f : triangles) {
    const Vec3 a = x[f[0]] - p, b = x[f[1]] - p, c = x[f[2]] - p;
    angle += 2 * std::atan2(a.dot(b.cross(c)), a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() +
                                                   b.dot(c) * a.norm() + c.dot(a) * b.norm());
  }
  return static_cast<int>(std::lround(angle / (4 * std::numbers::pi)));
}

bool in_tetrahedron(const ConvexPiece& piece, const Vec3& p) {
  Eigen::Matrix3d m;
  for (int i = 0; i < 3; ++i) m.col(i) = piece.points[static_cast<std::size_t>(i) + 1] - piece.points[0];
  const Vec3 w = m.inverse() * (p - piece.points[0]);
  return w.minCoeff() >= 0 && w.sum() <= 1;
}

TEST(ConvexPieces, SurfaceIsClosedAndOrientedAlike) {
  for (const ElementType type : kVolumes) {
    const Mesh mesh = permuted(block(type, 2, 1, 1), 7).mesh();
    for (Index o = 0; o < mesh.element_slots(); ++o) {
      std::vector<std::array<Index, 3>> triangles;
      detail::boundary_triangles(mesh, o, triangles);
      EXPECT_EQ(triangles.size(), 2 * mesh.vertices(o).size() - 4) << to_string(type);
      std::set<std::pair<Index, Index>> directed;
      for (const auto& f : triangles)
        for (std::size_t i = 0; i < 3; ++i) EXPECT_TRUE(directed.insert({f[i], f[(i + 1) % 3]}).second);
      for (const auto& [from, to] : directed) EXPECT_TRUE(directed.contains({to, from}));
    }
  }
}

TEST(ConvexPieces, QuadsAreSplitThroughTheSmallestVertex) {
  Mesh mesh;
  mesh.add_vertices(4);
  mesh.add_element({.type = ElementType::quad, .vertices = {2, 3, 1, 0}});
  std::vector<std::array<Index, 3>> triangles;
  detail::boundary_triangles(mesh, 0, triangles);
  ASSERT_EQ(triangles.size(), 2u);
  for (const auto& f : triangles) {
    EXPECT_EQ(f[0], 0u);
    EXPECT_TRUE(f[1] == 3u || f[2] == 3u);
  }
}

TEST(ConvexPieces, CoverTheBodyAndNothingElse) {
  std::mt19937_64 random(1);
  int exact = 0, surfaces = 0, inside = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const ElementType type = kVolumes[trial % 5];
    const Shape shape = permuted(block(type, 1, 1, 1), static_cast<std::uint64_t>(trial));
    const std::vector<Vec3> x = jittered(shape.positions, trial < 150 ? 0.2 : 0.6, static_cast<std::uint64_t>(trial));
    const Mesh mesh = shape.mesh();
    std::vector<std::array<Index, 3>> triangles;
    detail::boundary_triangles(mesh, 0, triangles);
    std::vector<ConvexPiece> within, around;
    const bool is_body = detail::append_pieces(mesh, x, 0, Cover::within, within);
    EXPECT_EQ(detail::append_pieces(mesh, x, 0, Cover::around, around), is_body);
    for (const ConvexPiece& piece : within) EXPECT_EQ(piece.count, is_body ? 4 : 3);
    ++(is_body ? exact : surfaces);
    for (int i = 0; i < 100; ++i) {
      const Vec3 p = Vec3::Constant(0.5) + random_point(random);
      const bool in_body = winding_number(triangles, x, p) != 0;
      const bool in_pieces =
          std::any_of(around.begin(), around.end(), [&](const ConvexPiece& q) { return in_tetrahedron(q, p); });
      EXPECT_TRUE(in_pieces || !in_body) << to_string(type) << " trial " << trial;
      if (is_body) {
        EXPECT_EQ(in_pieces, in_body) << to_string(type) << " trial " << trial;
      }
      inside += in_body;
    }
  }
  EXPECT_GT(exact, 150);
  EXPECT_GT(surfaces, 10);
  EXPECT_GT(inside, 1000);
}

ConvexPiece random_piece(std::mt19937_64& random, int count, double flatness, const Vec3& centre) {
  ConvexPiece piece;
  piece.count = count;
  for (Vec3& p : piece.points) {
    p = random_point(random);
    p.z() *= flatness;
    p += centre;
  }
  return piece;
}

/// Dense sampling of both pieces bounds the distance from above.
double sampled_distance(const ConvexPiece& a, const ConvexPiece& b, std::mt19937_64& random) {
  const auto sample = [&](const ConvexPiece& piece) {
    Eigen::Vector4d w = Eigen::Vector4d::Zero();
    std::exponential_distribution<double> exponential;
    for (int i = 0; i < piece.count; ++i) w[i] = exponential(random);
    w /= w.sum();
    Vec3 p = Vec3::Zero();
    for (int i = 0; i < piece.count; ++i) p += w[i] * piece.points[static_cast<std::size_t>(i)];
    return p;
  };
  double min = INFINITY;
  for (int i = 0; i < 200; ++i) min = std::min(min, (sample(a) - sample(b)).norm());
  return min;
}

TEST(SignedGap, IsALowerBoundOfTheDistance) {
  std::mt19937_64 random(2);
  for (int trial = 0; trial < 500; ++trial) {
    const ConvexPiece a = random_piece(random, 3 + trial % 2, 1, Vec3::Zero());
    const ConvexPiece b = random_piece(random, 3 + trial / 2 % 2, 1, 2 * random_point(random));
    EXPECT_LE(detail::signed_gap(a, b), sampled_distance(a, b, random) + 1e-12);
  }
}

TEST(SignedGap, MovingByTheDepthSeparates) {
  std::mt19937_64 random(3);
  int deep = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const ConvexPiece a = random_piece(random, 4, 1, Vec3::Zero());
    ConvexPiece b = random_piece(random, 4, 1, random_point(random));
    const double depth = -detail::signed_gap(a, b);
    if (depth <= 0) continue;
    ++deep;
    // No translation shorter than the depth separates the pieces.
    const Vec3 by = 0.99 * depth * random_point(random).normalized();
    for (Vec3& p : b.points) p += by;
    EXPECT_LE(detail::signed_gap(a, b), 0);
  }
  EXPECT_GT(deep, 100);
}

TEST(SignedGap, FlatPiecesInOnePlane) {
  const ConvexPiece a{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 0)}, 3};
  ConvexPiece b = a;
  for (Vec3& p : b.points) p = Vec3(1.1, 1.1, 0) - p;
  EXPECT_NEAR(detail::signed_gap(a, b), 1.2 / std::sqrt(2.0) - 2 / std::sqrt(2.0) + 1 / std::sqrt(2.0), 1e-12);
  for (Vec3& p : b.points) p -= Vec3(0.5, 0.5, 0);
  EXPECT_LE(detail::signed_gap(a, b), 0);
}

TEST(FclOverlap, AgreesWithSeparatingAxesBeyondItsTolerance) {
  std::mt19937_64 random(4);
  int overlaps = 0, apart = 0;
  detail::FclOverlap overlap;
  for (int trial = 0; trial < 40000; ++trial) {
    // The size and the place do not matter, because the query is scaled and centred.
    const double size = std::pow(10.0, trial % 13 - 6);
    const double flatness = trial % 3 == 0 ? 1e-2 : 1;
    ConvexPiece a = random_piece(random, 3 + trial % 2, flatness, Vec3::Zero());
    ConvexPiece b = random_piece(random, 3 + trial / 2 % 2, 1, random_point(random));
    for (ConvexPiece* piece : {&a, &b})
      for (Vec3& p : piece->points) p = size * (p + Vec3(3, -2, 5));
    const double gap = detail::signed_gap(a, b) / size;
    if (gap > 1e-9) {
      EXPECT_FALSE(overlap(a.span(), b.span())) << "trial " << trial << " gap " << gap;
      ++apart;
    } else if (gap < (flatness < 1 ? -1e-4 : -1e-5)) {
      EXPECT_TRUE(overlap(a.span(), b.span())) << "trial " << trial << " gap " << gap;
      ++overlaps;
    }
  }
  EXPECT_GT(overlaps, 5000);
  EXPECT_GT(apart, 5000);
}

TEST(FclOverlap, HullsOfManyPoints) {
  std::mt19937_64 random(6);
  detail::FclOverlap overlap;
  for (const std::size_t n : {8u, 20u, 100u}) {
    std::vector<Vec3> a, b;
    // Corners of a cube with half side 1, and interior points.
    for (std::size_t i = 0; i < 8; ++i) a.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    while (a.size() < n) a.push_back(0.9 * random_point(random));
    for (const Vec3& p : a) b.push_back(p + Vec3(1.9, 0.3, 1.9));
    EXPECT_TRUE(overlap(a, b)) << n;
    for (Vec3& p : b) p.x() += 0.2;
    EXPECT_FALSE(overlap(a, b)) << n;
  }
}

TEST(FclBoxes, AreThePairsThatOverlap) {
  std::mt19937_64 random(5);
  std::vector<detail::ElementBox> boxes;
  for (Index i = 0; i < 300; ++i) {
    const Vec3 centre = random_point(random), half = 0.15 * random_point(random).cwiseAbs();
    boxes.push_back({3 * i, centre - half, centre + half});
  }
  boxes.push_back({901, boxes[0].high, boxes[0].high});  // a point that touches a corner
  std::vector<ElementPair> expected;
  for (const auto& a : boxes)
    for (const auto& b : boxes)
      if (a.element < b.element && (a.low.array() <= b.high.array()).all() && (b.low.array() <= a.high.array()).all())
        expected.push_back({a.element, b.element});
  std::vector<ElementPair> found = detail::box_overlaps(boxes);
  std::sort(found.begin(), found.end());
  EXPECT_EQ(found, expected);
  EXPECT_GT(found.size(), 100u);
  EXPECT_TRUE(detail::box_overlaps({}).empty());
}

}  // namespace
}  // namespace volccd
