// Each condition of clear stars (docs/clear_stars.md), with stars that satisfy all others.
#include <volccd/culling/stars/vertex_stars.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <volccd/culling/stars/suspect_pairs.hpp>
#include <volccd/oracle/cases/shapes.hpp>

#include "culling/stars/ends_in_loop.hpp"

namespace volccd::detail {
namespace {

const ObjectFilter kAllObjects;

void add(Shape& shape, ElementType type, std::vector<Index> vertices) {
  shape.elements.push_back({type, std::move(vertices), {}, 0, static_cast<std::int64_t>(shape.elements.size())});
}

Shape with_positions(std::vector<Vec3> positions) {
  Shape shape;
  shape.positions = std::move(positions);
  return shape;
}

/// Vertex 0 is the centre, 1 to 4 are the corners of a square around the z axis, 5 is above, and 6 below. First the
/// tetrahedra below the square, then those above it.
Shape octahedron() {
  Shape shape = with_positions({{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {-4, 0, 0}, {0, -4, 0}, {0, 0, 4}, {0, 0, -4}});
  for (Index i = 0; i < 4; ++i) add(shape, ElementType::tetrahedron, {0, 1 + (i + 1) % 4, 1 + i, 6});
  for (Index i = 0; i < 4; ++i) add(shape, ElementType::tetrahedron, {0, 1 + i, 1 + (i + 1) % 4, 5});
  return shape;
}

/// Whether vertex 0 is suspect in the shape at rest.
bool is_suspect(const Shape& shape) {
  SerialExecutor serial;
  const Topology topology(shape.mesh());
  VertexStars stars;
  stars.update({topology, Motion::linear(shape.positions, shape.positions), kAllObjects}, serial);
  return stars.suspect(0);
}

/// The faces below the second cap have three tetrahedra. The first tetrahedron covers directions that no other covers.
TEST(ClearStars, HaveNoFacesOfThreeElements) {
  Shape shape = octahedron();
  EXPECT_FALSE(is_suspect(shape));
  shape.positions.emplace_back(0.5, 0.5, 3);
  for (Index i = 0; i < 4; ++i) add(shape, ElementType::tetrahedron, {0, 1 + i, 1 + (i + 1) % 4, 7});
  EXPECT_TRUE(is_suspect(shape));
}

/// A tetrahedron, and the same space divided into three, inside a star: their common faces have both on one side.
TEST(ClearStars, HaveElementsOnBothSidesOfFaces) {
  Shape shape = octahedron();
  for (const Vec3& p : {Vec3(2, 0.5, 0.5), Vec3(0.5, 2, 0.5), Vec3(0.5, 0.5, 2), Vec3(1.5, 1.5, 1.5)})
    shape.positions.push_back(p);
  add(shape, ElementType::tetrahedron, {0, 7, 8, 9});
  for (const auto& [a, b] : {std::array<Index, 2>{7, 8}, {8, 9}, {9, 7}})
    add(shape, ElementType::tetrahedron, {0, a, b, 10});
  EXPECT_TRUE(is_suspect(shape));
}

/// A small tetrahedron inside a larger one, with a common vertex: two rings.
TEST(ClearStars, HaveASingleRing) {
  Shape shape = with_positions({{0, 0, 0}, {8, 0, 0}, {0, 8, 0}, {0, 0, 8}, {3, 1, 1}, {1, 3, 1}, {1, 1, 3}});
  for (const bool small_first : {false, true}) {
    shape.elements.clear();
    add(shape, ElementType::tetrahedron, {0, 1, 2, 3});
    EXPECT_FALSE(is_suspect(shape));
    add(shape, ElementType::tetrahedron, {0, 4, 5, 6});
    if (small_first) std::swap(shape.elements[0].vertices, shape.elements[1].vertices);
    EXPECT_TRUE(is_suspect(shape)) << small_first;
    StarTable table;
    SerialExecutor serial;
    table.update(Topology(shape.mesh()), serial);
    EXPECT_EQ(table.kind(0), StarKind::irregular) << small_first;
  }
}

constexpr double kRadians = std::numbers::pi / 180;

/// Triangles around vertex 0, each `angle` degrees wide, that ascend. `closed`: the last one ends where the first one
/// begins.
Shape shell_fan(Index triangles, double angle, bool closed) {
  Shape shape = with_positions({Vec3::Zero()});
  const Index sides = closed ? triangles : triangles + 1;
  for (Index i = 0; i < sides; ++i) {
    const double turn = angle * kRadians * static_cast<double>(i);
    shape.positions.emplace_back(std::cos(turn), std::sin(turn), 0.02 * static_cast<double>(i));
  }
  for (Index i = 0; i < triangles; ++i) add(shape, ElementType::triangle, {0, 1 + i, 1 + (i + 1) % sides});
  return shape;
}

/// In the open fan, the last triangle lies over the first one.
TEST(ClearStars, HaveClosedRings) {
  EXPECT_FALSE(is_suspect(shell_fan(6, 60, true)));
  EXPECT_TRUE(is_suspect(shell_fan(4, 100, false)));
  EXPECT_TRUE(is_suspect(shell_fan(6, 120, true)));
}

/// A triangle that passes through the tetrahedra of a star, from its vertex.
TEST(ClearStars, HaveNotBothShellsAndVolumes) {
  for (const bool shell_first : {false, true}) {
    Shape shape = octahedron();
    shape.positions.emplace_back(1, 1.5, 0.5);
    shape.positions.emplace_back(1.5, 1, 2);
    add(shape, ElementType::triangle, {0, 7, 8});
    if (shell_first) std::swap(shape.elements.front(), shape.elements.back());
    EXPECT_TRUE(is_suspect(shape)) << shell_first;
  }
}

/// Triangles with a closed ring around `up`, in the middle of a closed star of tetrahedra.
TEST(ClearStars, HaveNoRingOfShellsAmongVolumes) {
  for (const bool shells_first : {false, true}) {
    Shape shape = octahedron();
    const auto volumes = static_cast<std::ptrdiff_t>(shape.elements.size());
    const Shape shells = shell_fan(6, 60, true);
    const auto first = static_cast<Index>(shape.positions.size() - 1);
    shape.positions.insert(shape.positions.end(), shells.positions.begin() + 1, shells.positions.end());
    for (const ElementSpec& e : shells.elements)
      add(shape, ElementType::triangle, {0, first + e.vertices[1], first + e.vertices[2]});
    if (shells_first) std::rotate(shape.elements.begin(), shape.elements.begin() + volumes, shape.elements.end());
    EXPECT_TRUE(is_suspect(shape)) << shells_first;
  }
}

/// How many faces of an element are irregular.
std::ptrdiff_t irregular_faces(const Shape& shape, Index o) {
  const Topology topology(shape.mesh());
  SerialExecutor serial;
  StarTable table;
  table.update(topology, serial);
  return std::count(table.faces(o).begin(), table.faces(o).end(), FaceKind::irregular);
}

TEST(ClearStars, HaveHexahedraOnBothSidesOfFaces) {
  Shape shape = block(ElementType::hexahedron, 1, 1, 1);
  for (const Vec3& p : {Vec3(0, 0, 2), Vec3(1, 0, 2), Vec3(0, 1, 2), Vec3(1, 1, 2)}) shape.positions.push_back(p);
  add(shape, ElementType::hexahedron, {4, 5, 7, 6, 8, 9, 11, 10});
  EXPECT_EQ(irregular_faces(shape, 0), 0);
  shape.elements.back().vertices = {0, 1, 3, 2, 8, 9, 11, 10};
  EXPECT_EQ(irregular_faces(shape, 0), 1);
  EXPECT_EQ(irregular_faces(shape, 1), 1);
}

/// A face of a hexahedron, of which a tetrahedron has one half, is irregular at the vertex of the other half, too.
TEST(ClearStars, HaveNoHalfCoveredFaces) {
  for (const Index min : {1u, 2u}) {
    Shape shape = block(ElementType::hexahedron, 1, 1, 1);
    ASSERT_EQ(shape.positions[7], Vec3(1, 1, 1));
    shape.positions.emplace_back(0.5, 0.5, 2);
    // The top has the vertices 4, 5, 7 and 6 in cyclic order, and its diagonal is that from 4 to 7.
    add(shape, ElementType::tetrahedron, min == 1 ? std::vector<Index>{4, 5, 7, 8} : std::vector<Index>{4, 7, 6, 8});
    const Topology topology(shape.mesh());
    SerialExecutor serial;
    StarTable table;
    table.update(topology, serial);
    EXPECT_EQ(irregular_faces(shape, 0), 1);
    for (const Index v : {4u, 5u, 6u, 7u}) EXPECT_EQ(table.kind(v), StarKind::irregular) << v;
  }
}

/// Tetrahedra and hexahedra that both surround vertex 0. The cones of hexahedra are over both triangles of each face.
TEST(ClearStars, AreNotTwoClosedStars) {
  for (int turn = 0; turn < 12; ++turn) {
    Shape shape = octahedron();
    const Eigen::AngleAxisd rotation(0.5 * turn, Vec3(1, 2, 3 + turn).normalized());
    for (Vec3& p : shape.positions) p = rotation * p;
    const Shape cells = block(ElementType::hexahedron, 2, 2, 2);
    const auto first = static_cast<Index>(shape.positions.size());
    for (const Vec3& p : cells.positions) shape.positions.push_back(p - Vec3(1, 1, 1));
    for (const ElementSpec& e : cells.elements) {
      std::vector<Index> vertices = e.vertices;
      for (Index& v : vertices) v = cells.positions[v] == Vec3(1, 1, 1) ? 0 : first + v;
      add(shape, ElementType::hexahedron, vertices);
    }
    EXPECT_TRUE(is_suspect(shape)) << turn;
  }
}

/// The boundary triangles of the faces at v, those without v included, have normals with positive dot products with
/// `up`, the sum of the unit normals of all triangles of these faces that contain v.
TEST(ClearStars, HaveFacesOverADirection) {
  SerialExecutor serial;
  std::size_t negative = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const Shape cell = permuted(block(ElementType::hexahedron, 1, 1, 1), seed);
    const Topology topology(cell.mesh());
    const std::vector<Vec3> x = jittered(cell.positions, 0.35, seed);
    VertexStars stars;
    stars.update({topology, Motion::linear(x, x), kAllObjects}, serial);
    const auto normal = [&](Index a, Index b, Index c) { return Vec3((x[b] - x[a]).cross(x[c] - x[a])); };
    for (Index v = 0; v < 8; ++v) {
      Vec3 up = Vec3::Zero();
      visit_faces(topology.mesh(), 0, [&](std::span<const Index> face, std::size_t) {
        const auto at = static_cast<std::size_t>(std::find(face.begin(), face.end(), v) - face.begin());
        if (at == 4) return;
        const Index a = face[(at + 1) % 4], b = face[(at + 2) % 4], c = face[(at + 3) % 4];
        for (const Vec3& n : {normal(v, a, b), normal(v, b, c), normal(v, a, c)}) up += n.normalized();
      });
      visit_faces(topology.mesh(), 0, [&](std::span<const Index> face, std::size_t) {
        if (std::find(face.begin(), face.end(), v) == face.end()) return;
        const auto min = static_cast<std::size_t>(std::min_element(face.begin(), face.end()) - face.begin());
        const auto at = [&](std::size_t i) { return face[(min + i) % 4]; };
        const bool over = up.dot(normal(at(0), at(1), at(2))) > 0 && up.dot(normal(at(0), at(2), at(3))) > 0;
        negative += over ? 0 : 1;
        EXPECT_TRUE(over || stars.suspect(v)) << seed << ' ' << v;
      });
    }
  }
  EXPECT_GT(negative, 20u);
}

/// Two poses in which all cones keep their signs: the first surrounds vertex 0 once, the second one twice.
struct WindingPoses {
  Shape shape;
  std::vector<Vec3> once, twice;
};

std::vector<WindingPoses> winding_poses() {
  std::vector<WindingPoses> all;
  const Shape once = shell_fan(12, 30, true), twice = shell_fan(12, 60, true);
  all.push_back({once, once.positions, twice.positions});
  for (const bool mirrored : {false, true}) {  // tetrahedra between a ring and two poles
    WindingPoses p;
    const double up = mirrored ? -1 : 1;
    for (const double angle : {60., 120.}) {
      std::vector<Vec3>& x = angle == 60 ? p.once : p.twice;
      x = {Vec3::Zero(), Vec3(0, 0, -up), Vec3(0, 0, up)};
      for (int i = 0; i < 6; ++i) x.emplace_back(std::cos(angle * kRadians * i), std::sin(angle * kRadians * i), 0);
    }
    p.shape.positions = p.once;
    for (Index i = 0; i < 6; ++i) {
      const Index u = 3 + i, w = 3 + (i + 1) % 6;
      add(p.shape, ElementType::tetrahedron, {0, w, u, 1});
      add(p.shape, ElementType::tetrahedron, {0, u, w, 2});
    }
    all.push_back(p);
  }
  return all;
}

/// The steps of one shape, with stars that are kept.
class KeptStars {
 public:
  explicit KeptStars(const Shape& shape) : topology_(shape.mesh()) {}
  bool suspect_after(const std::vector<Vec3>& from, const std::vector<Vec3>& to, Executor& executor) {
    stars_.update({topology_, Motion::linear(from, to), kAllObjects}, executor);
    return stars_.suspect(0);
  }
  bool suspect_after(const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
    SerialExecutor serial;
    return suspect_after(from, to, serial);
  }
  /// Adds a tetrahedron with vertices of its own to the mesh and to `positions`.
  void add_far_away(std::vector<Vec3>& positions) {
    const Index v = topology_.mesh().vertex_count();
    topology_.apply(
        {{}, {1000, 1001, 1002, 1003}, {{ElementType::tetrahedron, {v, v + 1, v + 2, v + 3}, {}, 0, 1000}}});
    for (const Vec3& p : {Vec3(90, 0, 0), Vec3(91, 0, 0), Vec3(90, 1, 0), Vec3(90, 0, 1)}) positions.push_back(p);
  }

 private:
  Topology topology_;
  VertexStars stars_;
};

TEST(ClearStars, AreCheckedAgainAfterAJump) {
  for (const WindingPoses& p : winding_poses()) {
    KeptStars steps(p.shape);
    EXPECT_FALSE(steps.suspect_after(p.once, p.once));
    EXPECT_TRUE(steps.suspect_after(p.twice, p.twice));
    EXPECT_FALSE(steps.suspect_after(p.once, p.once));
  }
}

TEST(ClearStars, AreCheckedAgainAfterAJumpInWhichVerticesAreAdded) {
  for (WindingPoses p : winding_poses()) {
    KeptStars steps(p.shape);
    EXPECT_FALSE(steps.suspect_after(p.once, p.once));
    steps.add_far_away(p.twice);
    EXPECT_TRUE(steps.suspect_after(p.twice, p.twice));
  }
}

TEST(ClearStars, AreCheckedAgainAfterAStepInWhichTheyWereSuspect) {
  for (const WindingPoses& p : winding_poses()) {
    KeptStars steps(p.shape);
    EXPECT_FALSE(steps.suspect_after(p.once, p.once));
    EXPECT_TRUE(steps.suspect_after(p.once, p.twice));
    EXPECT_TRUE(steps.suspect_after(p.twice, p.twice));
    EXPECT_TRUE(steps.suspect_after(p.twice, p.once));
    EXPECT_FALSE(steps.suspect_after(p.once, p.once));
  }
}

TEST(ClearStars, AreCheckedAgainAfterAnInterruptedStep) {
  for (const WindingPoses& p : winding_poses())
    for (int loop = 0; loop < 10; ++loop) {
      KeptStars steps(p.shape);
      EXPECT_FALSE(steps.suspect_after(p.once, p.once));
      EndsInLoop interrupted(loop);
      try {
        steps.suspect_after(p.twice, p.twice, interrupted);
      } catch (const std::runtime_error&) {
      }
      EXPECT_TRUE(steps.suspect_after(p.twice, p.twice)) << loop;
    }
}

TEST(ClearStars, OfVerticesThatBeginToHaveElementsAreClassified) {
  SerialExecutor serial;
  const Shape shape = octahedron();
  std::vector<Vec3> x = shape.positions;
  for (const Vec3& p : {Vec3(9, 0, 0), Vec3(10, 0, 0), Vec3(9, 1, 0), Vec3(9, 0, 1)}) x.push_back(p);
  std::vector<Vec3> end = x;
  end.back() = Vec3(9, 0, -1);  // the volume changes its sign
  Shape all = shape;
  all.positions = x;
  Topology topology(all.mesh());
  VertexStars stars;
  stars.update({topology, Motion::linear(x, end), kAllObjects}, serial);
  topology.apply({{}, {}, {{ElementType::tetrahedron, {7, 8, 9, 10}, {}, 0, 100}}});
  stars.update({topology, Motion::linear(x, end), kAllObjects}, serial);
  for (const Index v : {7u, 8u, 9u, 10u}) EXPECT_TRUE(stars.suspect(v)) << v;
}

/// Two tetrahedra with positive volumes on the same side of a common face overlap, although their volumes have one
/// sign.
TEST(SuspectPairs, OfTetrahedraOnOneSideOfAFaceAreListed) {
  SerialExecutor serial;
  for (const int elements : {2, 3}) {
    Shape shape = with_positions({{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {1, 1, 4}, {1, 2, 3}, {1, 1, -4}});
    add(shape, ElementType::tetrahedron, {0, 1, 2, 3});
    add(shape, ElementType::tetrahedron, {0, 1, 2, 4});
    if (elements == 3) add(shape, ElementType::tetrahedron, {0, 2, 1, 5});
    const Topology topology(shape.mesh());
    const Motion rest = Motion::linear(shape.positions, shape.positions);
    const Step step{topology, rest, kAllObjects};
    VertexStars stars;
    stars.update(step, serial);
    SuspectPairs pairs;
    pairs.update(step, stars, serial, [](Index, Index) { return true; });
    EXPECT_EQ(std::count(pairs.pairs().begin(), pairs.pairs().end(), ElementPair{0, 1}), 1) << elements;
    EXPECT_EQ(std::count(pairs.pairs().begin(), pairs.pairs().end(), ElementPair{0, 0}), 0) << elements;
  }
}

}  // namespace
}  // namespace volccd::detail
