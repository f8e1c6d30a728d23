// The models of the scenes bullet, airbag and crash have the properties that a simulation requires of a mesh.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include <volccd/core/error.hpp>
#include <volccd/core/executor.hpp>
#include <volccd/experiments/scenes/geometry/folded_airbag.hpp>
#include <volccd/experiments/scenes/geometry/quad_complex.hpp>
#include <volccd/experiments/scenes/geometry/vehicle_front.hpp>
#include <volccd/experiments/scenes/simulated/airbag.hpp>
#include <volccd/experiments/scenes/simulated/bullet.hpp>
#include <volccd/experiments/scenes/simulated/crash.hpp>
#include <volccd/mesh/shells.hpp>

#include "support/one_step.hpp"

namespace volccd {
namespace {

using simulation::Model;
using Edge = std::pair<Index, Index>;

/// Neighbours of each corner of a hexahedron, in an order in which its edges form a right-handed frame.
constexpr std::size_t kNext[8][3] = {{1, 3, 4}, {2, 0, 5}, {3, 1, 6}, {0, 2, 7},
                                     {7, 5, 0}, {4, 6, 1}, {5, 7, 2}, {6, 4, 3}};

/// The least value, over all corners, of the volume spanned by the edges divided by the product of their lengths: 1 for
/// right angles.
double min_scaled_jacobian(const Model& model) {
  double min = 1;
  for (Index o = 0; o < model.mesh.element_slots(); ++o)
    for (std::size_t c = 0; c < 8; ++c) {
      const auto v = model.mesh.vertices(o);
      const auto edge = [&](std::size_t k) -> Vec3 {
        return (model.positions[v[kNext[c][k]]] - model.positions[v[c]]).normalized();
      };
      min = std::min(min, edge(0).cross(edge(1)).dot(edge(2)));
    }
  return min;
}

/// Numbers of elements at each edge by direction: [0] from the lower to the higher vertex, [1] the reverse. For
/// triangles.
std::map<Edge, std::array<int, 2>> edge_uses(const Mesh& mesh, std::int32_t first_object, std::int32_t last_object) {
  std::map<Edge, std::array<int, 2>> uses;
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (mesh.object(o) < first_object || mesh.object(o) > last_object) continue;
    const auto v = mesh.vertices(o);
    for (std::size_t i = 0; i < 3; ++i) {
      const Index a = v[i], b = v[(i + 1) % 3];
      ++uses[std::minmax(a, b)][a < b ? 0 : 1];
    }
  }
  return uses;
}

double enclosed_volume(const Model& model, std::int32_t first_object, std::int32_t last_object) {
  double volume = 0;
  for (Index o = 0; o < model.mesh.element_slots(); ++o) {
    if (model.mesh.object(o) < first_object || model.mesh.object(o) > last_object) continue;
    const auto v = model.mesh.vertices(o);
    volume += model.positions[v[0]].dot(model.positions[v[1]].cross(model.positions[v[2]])) / 6;
  }
  return volume;
}

/// Number of pieces that are connected by vertices; a vertex without an element counts as a piece.
std::size_t pieces(const Mesh& mesh) {
  std::vector<Index> root(mesh.vertex_count());
  std::iota(root.begin(), root.end(), Index{0});
  const auto find = [&](Index v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  for (Index o = 0; o < mesh.element_slots(); ++o)
    for (const Index v : mesh.vertices(o)) root[find(v)] = find(mesh.vertices(o)[0]);
  std::set<Index> roots;
  for (Index v = 0; v < mesh.vertex_count(); ++v) roots.insert(find(v));
  return roots.size();
}

/// The elements that collide: shells are thickened to solids.
std::vector<ElementPair> initial_overlaps(const Model& model) {
  Mesh mesh = model.mesh;
  std::vector<Vec3> x = model.positions;
  if (is_shell(mesh.type(0))) {
    std::vector<double> thickness(mesh.element_slots());
    for (Index o = 0; o < mesh.element_slots(); ++o)
      thickness[o] = model.bodies[static_cast<std::size_t>(mesh.object(o))].thickness;
    const ShellThickener thickener(mesh);
    thickener.positions(model.positions, thickness, x);
    mesh = thickener.solid_mesh(mesh);
  }
  const Topology topology(std::move(mesh));
  const Motion motion = Motion::linear(x, x);
  return test::run_step({topology, motion, test::kAllObjects}, {.query = Query::first, .initial_overlaps = true})
      .initial_overlaps;
}

bool same(const Model& a, const Model& b) {
  return a.positions == b.positions && a.velocities == b.velocities && a.fixed == b.fixed;
}

/// Number of free edges that contain a vertex of the mesh, where the mesh is not conforming.
std::size_t hanging_vertices(const Model& model) {
  std::size_t hanging = 0;
  for (const auto& [edge, uses] : edge_uses(model.mesh, 0, kVehicleParts)) {
    if (uses[0] + uses[1] != 1) continue;
    const Vec3 a = model.positions[edge.first], way = model.positions[edge.second] - a;
    for (const Vec3& p : model.positions) {
      const double t = (p - a).dot(way) / way.squaredNorm();
      hanging += t > 0.05 && t < 0.95 && (p - a - t * way).norm() < 0.05 * way.norm();
    }
  }
  return hanging;
}

void expect_about(const Model& model, int elements) {
  EXPECT_NEAR(model.mesh.element_count(), elements, 0.03 * elements);
  EXPECT_EQ(model.positions.size(), model.mesh.vertex_count());
  EXPECT_EQ(model.velocities.size(), model.mesh.vertex_count());
}

TEST(QuadComplex, DividesCommonSidesAlikeAndBendsThem) {
  QuadComplex complex;
  complex.patch(0, {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0});
  complex.patch(1, {1, 0, 0}, {3, 0, 0}, {3, 1, 0}, {1, 1, 0});
  complex.patch(2, {1, 0, 0}, {1, 1, 0}, {1, 1, 1}, {1, 0, 1});  // a third element at the side x = 1
  complex.bend({3, 0, 0}, {3, 1, 0}, [](const Vec3& p) { return Vec3(3 + p.y() * (1 - p.y()), p.y(), 0); });
  const Shape shape = complex.mesh(0.25);
  EXPECT_EQ(shape.elements.size(), 2u * (4 * 4 + 8 * 4 + 4 * 4));
  EXPECT_EQ(complex.triangle_count(0.25), static_cast<std::int64_t>(shape.elements.size()));
  EXPECT_EQ(shape.positions.size(), 5u * 5 + 8 * 5 + 5 * 4);
  const auto uses = edge_uses(shape.mesh(), 0, 2);
  EXPECT_EQ(std::count_if(uses.begin(), uses.end(), [](const auto& e) { return e.second[0] + e.second[1] == 3; }), 4);
  double farthest = 0;
  for (const Vec3& p : shape.positions) farthest = std::max(farthest, p.x());
  EXPECT_DOUBLE_EQ(farthest, 3.25);
  EXPECT_THROW(complex.bend({0, 0, 0}, {1, 1, 0}, {}), ConfigError) << "a diagonal is no side";
  EXPECT_THROW(complex.patch(0, {0, 0, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0}), ConfigError);
  EXPECT_THROW(static_cast<void>(complex.spacing_for(5)), ConfigError);
}

TEST(BulletModel, HexahedraAreSoundAtEverySize) {
  for (const int elements : {kBulletQuickElements, 4'000, kBulletElements}) {
    const Model model = bullet_model(elements);
    expect_about(model, elements);
    EXPECT_GT(min_scaled_jacobian(model), 0.3) << elements;
    EXPECT_EQ(pieces(model.mesh), 2u);
  }
}

TEST(BulletModel, HasTheSizesThatItSays) {
  const Model model = bullet_model(kBulletElements);
  Eigen::AlignedBox3d bullet, plate;
  for (std::size_t v = 0; v < model.positions.size(); ++v)
    (model.velocities[v].z() < 0 ? bullet : plate).extend(model.positions[v]);
  EXPECT_NEAR(bullet.sizes().z(), 0.024, 5e-4);
  EXPECT_NEAR(bullet.sizes().x(), 0.010, 6e-4);
  EXPECT_TRUE(plate.sizes().isApprox(Vec3(0.1, 0.1, 0.005), 1e-9));
  EXPECT_GT(bullet.min().z(), 0);
  EXPECT_LT(bullet.min().z(), 0.001);
  EXPECT_FALSE(model.fixed.empty());
  for (const Index v : model.fixed) EXPECT_NEAR(model.positions[v].cwiseAbs().head<2>().maxCoeff(), 0.05, 1e-12);
}

TEST(BulletModel, FacesConform) {
  const Model model = bullet_model(kBulletQuickElements);
  std::map<std::array<Index, 4>, int> faces;
  for (Index o = 0; o < model.mesh.element_slots(); ++o) {
    const auto v = model.mesh.vertices(o);
    const auto stream = face_stream(ElementType::hexahedron);
    for (std::size_t i = 0; i < stream.size(); i += 5) {
      std::array<Index, 4> face{v[stream[i + 1]], v[stream[i + 2]], v[stream[i + 3]], v[stream[i + 4]]};
      std::sort(face.begin(), face.end());
      EXPECT_LE(++faces[face], 2);
    }
  }
  // Two closed surfaces of genus 0: quads F and vertices V of the boundary satisfy V = F + 2 for each.
  std::set<Index> vertices;
  std::size_t outer = 0;
  for (const auto& [face, uses] : faces) {
    if (uses != 1) continue;
    ++outer;
    vertices.insert(face.begin(), face.end());
  }
  EXPECT_EQ(vertices.size(), outer + 4);
}

TEST(AirbagModel, SurfacesAreClosedAndFaceOutwards) {
  for (const int elements : {kAirbagQuickElements, kAirbagElements}) {
    const Model model = airbag_model(elements);
    expect_about(model, elements);
    EXPECT_EQ(pieces(model.mesh), 2u) << "bag and wheel";
    for (const auto& [first, last] : {std::pair{0, 1}, std::pair{2, 2}}) {
      const auto uses = edge_uses(model.mesh, first, last);
      for (const auto& [edge, directions] : uses)
        ASSERT_EQ(directions, (std::array{1, 1})) << edge.first << " " << edge.second;
      EXPECT_GT(enclosed_volume(model, first, last), 0);
    }
    const double volume = enclosed_volume(model, 0, 1), flat = M_PI * 0.33 * 0.33 * AirbagShape{}.gap;
    EXPECT_GT(volume, 0.7 * flat);
    EXPECT_LT(volume, 1.05 * flat);
  }
}

TEST(AirbagModel, FoldsKeepTheLengthOfTheFabric) {
  const Model model = airbag_model(kAirbagElements);
  double area = 0;
  for (Index o = 0; o < model.mesh.element_slots(); ++o) {
    if (model.mesh.object(o) > 1) continue;
    const auto v = model.mesh.vertices(o);
    area +=
        (model.positions[v[1]] - model.positions[v[0]]).cross(model.positions[v[2]] - model.positions[v[0]]).norm() / 2;
  }
  const double flat = 2 * M_PI * 0.33 * 0.33;
  EXPECT_NEAR(area, flat, 0.05 * flat);
  Eigen::AlignedBox3d bag;
  for (std::size_t v = 0; v < model.positions.size(); ++v)
    if (model.positions[v].z() > -0.003) bag.extend(model.positions[v]);
  EXPECT_LT(bag.sizes().x(), 0.2) << "folded";
  EXPECT_GT(bag.sizes().y(), 0.64) << "not folded along y";
  EXPECT_LT(bag.sizes().z(), 0.04);
}

TEST(CrashModel, IsOneConformingPieceAtEverySize) {
  for (const int elements : {kCrashQuickElements, kCrashElements}) {
    const Model model = crash_model(elements);
    expect_about(model, elements);
    EXPECT_EQ(pieces(model.mesh), 2u) << "car and wall";
  }
  EXPECT_EQ(hanging_vertices(crash_model(3'000)), 0u);
}

TEST(CrashModel, HasThePartsOfACar) {
  const Model model = crash_model(kCrashQuickElements);
  ASSERT_EQ(model.bodies.size(), static_cast<std::size_t>(kVehicleParts) + 1);
  std::vector<double> area(model.bodies.size(), 0);
  for (Index o = 0; o < model.mesh.element_slots(); ++o) {
    const auto v = model.mesh.vertices(o);
    area[static_cast<std::size_t>(model.mesh.object(o))] +=
        (model.positions[v[1]] - model.positions[v[0]]).cross(model.positions[v[2]] - model.positions[v[0]]).norm() / 2;
  }
  double mass = 0;
  for (std::size_t part = 0; part < static_cast<std::size_t>(kVehicleParts); ++part) {
    EXPECT_GT(area[part], 0) << model.bodies[part].name;
    mass += area[part] * model.bodies[part].thickness * model.bodies[part].material.density;
  }
  EXPECT_NEAR(mass, 900, 150);
  // The wall is the last part: in front of the car, wider, higher and lower than it will be, and fixed.
  EXPECT_TRUE(model.walls.empty());
  EXPECT_EQ(model.bodies.back().name, "wall");
  EXPECT_TRUE(model.bodies.back().rigid);
  EXPECT_NEAR(area.back(), 1.9 * 1.12, 1e-9);
  Eigen::AlignedBox3d car, wall;
  for (std::size_t v = 0; v < model.positions.size(); ++v)
    (model.velocities[v].x() < 0 ? car : wall).extend(model.positions[v]);
  EXPECT_NEAR(car.min().x() - wall.max().x(), 0.02, 0.001) << "15 mm, and half the thickness";
  EXPECT_LT(wall.min().y(), car.min().y() - 0.1);
  EXPECT_GT(wall.max().y(), car.max().y() + 0.1);
  EXPECT_LT(wall.min().z(), car.min().z());
  for (const Index v : model.fixed) EXPECT_EQ(model.velocities[v], Vec3::Zero());
  EXPECT_EQ(model.fixed.size(), static_cast<std::size_t>(std::ranges::count(model.velocities, Vec3(Vec3::Zero()))));
}

TEST(SolidAndShellModels, NothingOverlapsAtTheStart) {
  EXPECT_EQ(initial_overlaps(bullet_model(kBulletQuickElements)).size(), 0u);
  EXPECT_EQ(initial_overlaps(airbag_model(kAirbagQuickElements)).size(), 0u);
  EXPECT_EQ(initial_overlaps(crash_model(kCrashQuickElements)).size(), 0u);
}

TEST(LongSolidAndShellModels, NothingOverlapsAtTheStartByDefault) {
  EXPECT_EQ(initial_overlaps(bullet_model()).size(), 0u);
  EXPECT_EQ(initial_overlaps(airbag_model()).size(), 0u);
  EXPECT_EQ(initial_overlaps(crash_model()).size(), 0u);
}

TEST(SolidAndShellModels, FollowFromSizeAndSeed) {
  EXPECT_TRUE(same(bullet_model(1'500, 7), bullet_model(1'500, 7)));
  EXPECT_FALSE(same(bullet_model(1'500, 7), bullet_model(1'500, 8)));
  EXPECT_TRUE(same(airbag_model(1'500, 7), airbag_model(1'500, 7)));
  EXPECT_FALSE(same(airbag_model(1'500, 7), airbag_model(1'500, 8)));
  EXPECT_TRUE(same(crash_model(3'000, 7), crash_model(3'000, 7)));
  EXPECT_FALSE(same(crash_model(3'000, 7), crash_model(3'000, 8)));
}

TEST(SolidAndShellModels, RefuseSizesThatCannotBe) {
  EXPECT_THROW(bullet_model(10), ConfigError);
  EXPECT_THROW(airbag_model(100), ConfigError);
  EXPECT_THROW(crash_model(1'000), ConfigError);
}

}  // namespace
}  // namespace volccd
