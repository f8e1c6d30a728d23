#include <volccd/experiments/scenes/geometry/tetrahedra.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include <Eigen/Geometry>

#include <volccd/core/error.hpp>
#include <volccd/experiments/scenes/geometry/octopus.hpp>
#include <volccd/experiments/scenes/simulated/liver.hpp>
#include <volccd/experiments/scenes/simulated/octopi.hpp>

#include "support/one_step.hpp"

namespace volccd {
namespace {

ImplicitSolid ball(const Vec3& centre) {
  ImplicitSolid solid;
  solid.low = centre - Vec3::Constant(1);
  solid.high = centre + Vec3::Constant(1);
  solid.value = [centre](const Vec3& p) { return (p - centre).norm() - 1; };
  return solid;
}

std::array<Vec3, 4> corners(const std::vector<Vec3>& x, std::span<const Index> v) {
  return {x[v[0]], x[v[1]], x[v[2]], x[v[3]]};
}

double volume(const std::array<Vec3, 4>& x) { return (x[1] - x[0]).cross(x[2] - x[0]).dot(x[3] - x[0]) / 6; }

struct Measure {
  double volume = 0, smallest_volume = INFINITY, smallest_angle = 180, largest_angle = 0;
};

Measure measure(const Shape& shape) {
  Measure m;
  for (const ElementSpec& e : shape.elements) {
    const auto x = corners(shape.positions, e.vertices);
    m.volume += volume(x);
    m.smallest_volume = std::min(m.smallest_volume, volume(x));
    // The dihedral angle at edge ij, between the faces with the corners k and l.
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j) {
        const std::size_t k = i == 0 ? (j == 1 ? 2 : 1) : 0, l = 6 - i - j - k;
        const Vec3 edge = x[j] - x[i], p = edge.cross(x[k] - x[i]), q = edge.cross(x[l] - x[i]);
        const double angle = std::atan2(p.cross(q).norm(), p.dot(q)) * 180 / std::numbers::pi;
        m.smallest_angle = std::min(m.smallest_angle, angle);
        m.largest_angle = std::max(m.largest_angle, angle);
      }
  }
  return m;
}

/// Faces of only one element, with the orientation outwards from it, by their sorted vertices. Also checks that no face
/// has more than two elements, and that two elements lie on different sides of their common face.
std::vector<std::array<Index, 3>> surface(const Shape& shape) {
  constexpr int outward[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  std::map<std::array<Index, 3>, std::vector<std::array<Index, 3>>> faces;
  for (const ElementSpec& e : shape.elements)
    for (const auto& f : outward) {
      const std::array<Index, 3> face = {e.vertices[f[0]], e.vertices[f[1]], e.vertices[f[2]]};
      std::array<Index, 3> key = face;
      std::sort(key.begin(), key.end());
      faces[key].push_back(face);
    }
  std::vector<std::array<Index, 3>> boundary;
  for (const auto& [key, sides] : faces) {
    EXPECT_LE(sides.size(), 2u) << "a face of three elements";
    if (sides.size() == 1) boundary.push_back(sides[0]);
    if (sides.size() != 2) continue;
    std::array<Index, 3> turned = {sides[1][0], sides[1][2], sides[1][1]};
    while (turned[0] != sides[0][0]) std::rotate(turned.begin(), turned.begin() + 1, turned.end());
    EXPECT_EQ(turned, sides[0]) << "two elements on the same side of a face";
  }
  return boundary;
}

/// Checks that each directed edge of the surface occurs once in each direction; returns vertices - edges + faces.
int closed_surface_characteristic(const std::vector<std::array<Index, 3>>& faces) {
  std::map<std::pair<Index, Index>, int> edges;
  std::map<Index, int> vertices;
  for (const auto& f : faces)
    for (std::size_t i = 0; i < 3; ++i) {
      ++edges[{f[i], f[(i + 1) % 3]}];
      ++vertices[f[i]];
    }
  for (const auto& [edge, times] : edges) {
    EXPECT_EQ(times, 1);
    EXPECT_TRUE(edges.contains({edge.second, edge.first})) << "a hole";
  }
  return static_cast<int>(vertices.size()) - static_cast<int>(edges.size()) / 2 + static_cast<int>(faces.size());
}

TEST(Tetrahedra, FillABallConformingAndClosedWithoutFlatOnes) {
  for (const double edge : {0.5, 0.31, 0.17}) {
    const ImplicitSolid solid = ball({0.1, -0.2, 0.05});
    const Shape shape = fill_with_tetrahedra(solid, edge);
    const auto faces = surface(shape);
    EXPECT_EQ(closed_surface_characteristic(faces), 2) << "not a sphere at edge " << edge;
    for (const auto& f : faces)
      for (const Index v : f) EXPECT_LT(std::abs(solid.value(shape.positions[v])), 1e-3 * edge);
    const Measure m = measure(shape);
    EXPECT_GT(m.smallest_volume, 0.005 * edge * edge * edge);
    EXPECT_GT(m.smallest_angle, 18);
    EXPECT_LT(m.largest_angle, 150);
    // The surface is inscribed, so that its radius is smaller by about edge^2 / 8.
    const double ball_volume = 4 * std::numbers::pi / 3;
    EXPECT_LT(m.volume, ball_volume);
    EXPECT_GT(m.volume, ball_volume * (1 - 0.45 * edge * edge));
  }
}

TEST(Tetrahedra, StayGoodWhereverTheLatticeMeetsTheSurface) {
  Measure worst;
  for (int i = 0; i < 20; ++i) {
    ImplicitSolid solid = ball(Vec3::Zero());
    // The lattice is centred on the box, so that it moves with the corner of the box.
    solid.low -= Vec3(0.021 * i, 0.013 * i, 0.033 * i);
    const Shape shape = fill_with_tetrahedra(solid, 0.4);
    EXPECT_EQ(closed_surface_characteristic(surface(shape)), 2);
    const Measure m = measure(shape);
    worst.smallest_angle = std::min(worst.smallest_angle, m.smallest_angle);
    worst.largest_angle = std::max(worst.largest_angle, m.largest_angle);
    worst.smallest_volume = std::min(worst.smallest_volume, m.smallest_volume);
  }
  EXPECT_GT(worst.smallest_volume, 0);
  EXPECT_GT(worst.smallest_angle, 18);
  EXPECT_LT(worst.largest_angle, 150);
}

TEST(Tetrahedra, AreAsManyAsWanted) {
  for (const int wanted : {500, 2000, 9000}) {
    const double count = static_cast<double>(fill_with_about(ball(Vec3::Zero()), wanted).elements.size());
    EXPECT_NEAR(count, wanted, 0.03 * wanted);
  }
}

TEST(Tetrahedra, OfAnOctopusHangTogetherByFaces) {
  OctopusPose pose;
  pose.thinnest = 0.0215;
  const Shape shape = fill_with_about(octopus_solid(pose), 1000);
  std::vector<std::size_t> piece(shape.elements.size());
  std::map<std::array<Index, 3>, std::size_t> owner;
  for (std::size_t i = 0; i < piece.size(); ++i) piece[i] = i;
  const auto find = [&](std::size_t i) {
    while (piece[i] != i) i = piece[i];
    return i;
  };
  for (std::size_t i = 0; i < piece.size(); ++i)
    for (std::size_t skip = 0; skip < 4; ++skip) {
      std::vector<Index> face = shape.elements[i].vertices;
      face.erase(face.begin() + static_cast<std::ptrdiff_t>(skip));
      std::sort(face.begin(), face.end());
      const auto [other, is_new] = owner.try_emplace({face[0], face[1], face[2]}, i);
      if (!is_new) piece[find(i)] = find(other->second);
    }
  for (std::size_t i = 0; i < piece.size(); ++i) EXPECT_EQ(find(i), find(0));
  // The mesh has all eight tentacles: parts far from the body in eight directions.
  std::vector<bool> sector(8, false);
  for (const Vec3& p : shape.positions)
    if (std::hypot(p.x(), p.y()) > 0.09)
      sector[static_cast<std::size_t>((std::atan2(p.y(), p.x()) / std::numbers::pi + 1) * 4) % 8] = true;
  EXPECT_EQ(std::count(sector.begin(), sector.end(), true), 8);
}

TEST(Tetrahedra, RefuseWhatCannotBeFilled) {
  EXPECT_THROW(fill_with_tetrahedra(ball(Vec3::Zero()), 0), ConfigError);
  EXPECT_THROW(fill_with_tetrahedra(ball(Vec3::Zero()), NAN), ConfigError);
  EXPECT_THROW(fill_with_tetrahedra(ball(Vec3::Zero()), 1e-4), ConfigError);
  EXPECT_THROW(fill_with_about(ball(Vec3::Zero()), 0), ConfigError);
  ImplicitSolid nothing = ball(Vec3::Zero());
  nothing.value = [](const Vec3&) { return 1.0; };
  EXPECT_THROW(fill_with_tetrahedra(nothing, 0.3), ConfigError);
  nothing.value = [](const Vec3&) { return double{NAN}; };
  EXPECT_THROW(fill_with_tetrahedra(nothing, 0.3), ConfigError);
}

void expect_sound(const simulation::Model& model, int elements) {
  EXPECT_NEAR(model.mesh.element_count(), elements, 0.03 * elements);
  ASSERT_EQ(model.positions.size(), model.mesh.vertex_count());
  ASSERT_EQ(model.velocities.size(), model.mesh.vertex_count());
  for (Index o = 0; o < model.mesh.element_slots(); ++o) {
    EXPECT_GT(volume(corners(model.positions, model.mesh.vertices(o))), 0);
    EXPECT_LT(static_cast<std::size_t>(model.mesh.object(o)), model.bodies.size());
  }
  EXPECT_TRUE(model.walls.empty());
  const Topology topology(model.mesh);
  const Motion still = Motion::linear(model.positions, model.positions);
  const StepResult result = test::run_step({topology, still, test::kAllObjects}, {.initial_overlaps = true});
  EXPECT_EQ(result.initial_overlaps.size(), 0u);
  EXPECT_EQ(result.contacts.size(), 0u);
}

TEST(SimulatedSolids, BeginWithoutOverlap) {
  expect_sound(octopi_model(kOctopiQuickElements), kOctopiQuickElements);
  expect_sound(liver_model(kLiverQuickElements), kLiverQuickElements);
}

TEST(SimulatedSolids, AreTheSameFromTheSameSeedOnly) {
  const auto same = [](const simulation::Model& a, const simulation::Model& b) {
    return a.positions == b.positions && a.velocities == b.velocities &&
           a.mesh.element_count() == b.mesh.element_count();
  };
  EXPECT_TRUE(same(liver_model(800, 3), liver_model(800, 3)));
  EXPECT_FALSE(same(liver_model(800, 3), liver_model(800, 4)));
  EXPECT_TRUE(same(octopi_model(1500, 3), octopi_model(1500, 3)));
}

TEST(SimulatedSolids, RefuseSizesOutOfRange) {
  EXPECT_THROW(octopi_model(100), ConfigError);
  EXPECT_THROW(liver_model(100), ConfigError);
}

}  // namespace
}  // namespace volccd
