// The inversion test: which motions it finds, and at which contacts it points.
#include <volccd/experiments/harness/corner_volumes.hpp>
#include <volccd/experiments/tables/inversion_table.hpp>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/oracle/cases/shapes.hpp>

#include "support/one_step.hpp"

namespace volccd {
namespace {

const ElementType kSolids[] = {ElementType::tetrahedron, ElementType::pyramid, ElementType::wedge,
                               ElementType::hexahedron};

TEST(CornerTetrahedra, HaveTheVolumeOfTheirElement) {
  for (const ElementType type : kSolids) {
    const Shape shape = block(type, 1, 1, 1);
    for (const ElementSpec& element : shape.elements) {
      std::vector<Index> vertices(element.vertices.begin(), element.vertices.end());
      ASSERT_FALSE(corner_tetrahedra(type).empty());
      for (const auto& corner : corner_tetrahedra(type))
        // 6 times the volume: 1 for a unit cube and its prisms and tetrahedra, 1/2 for a sixth of it with its centre.
        EXPECT_NEAR(corner_volume(corner, vertices, shape.positions), type == ElementType::pyramid ? 0.5 : 1, 1e-12)
            << to_string(type);
    }
  }
  EXPECT_TRUE(corner_tetrahedra(ElementType::quad).empty());
  EXPECT_TRUE(corner_tetrahedra(ElementType::polytope).empty());
}

Inversion of_first_element(const Shape& shape, const std::vector<Vec3>& x1) {
  const std::vector<Index> vertices(shape.elements[0].vertices.begin(), shape.elements[0].vertices.end());
  return inversion(shape.mesh().type(0), vertices, Motion::linear(shape.positions, x1));
}

/// Rotates the element by half a turn about an axis. On straight trajectories it is flat in the middle of the motion,
/// and has its volume again at the end, so that the two ends show nothing.
std::vector<Vec3> half_turn(std::vector<Vec3> positions) {
  for (Vec3& p : positions) p = Vec3(1 - p.x(), 1 - p.y(), p.z());
  return positions;
}

TEST(Inversion, OfOneElement) {
  for (const ElementType type : kSolids) {
    const Shape shape = block(type, 1, 1, 1);
    std::vector<Vec3> moved = shape.positions, mirrored = shape.positions;
    for (Vec3& p : moved) p += Vec3(1, 2, 3);
    for (Vec3& p : mirrored) p.z() = -p.z();
    EXPECT_EQ(of_first_element(shape, shape.positions), Inversion::none) << to_string(type);
    EXPECT_EQ(of_first_element(shape, moved), Inversion::none) << to_string(type);
    EXPECT_EQ(of_first_element(shape, mirrored), Inversion::during) << to_string(type);
    EXPECT_EQ(of_first_element(shape, half_turn(shape.positions)), Inversion::during) << to_string(type);
    Shape wrong = shape;
    wrong.positions = mirrored;
    EXPECT_EQ(of_first_element(wrong, shape.positions), Inversion::at_start) << to_string(type);
    EXPECT_EQ(of_first_element(wrong, mirrored), Inversion::at_start) << to_string(type);
  }
  // One corner of a hexahedron is pushed through the others; the volume of the whole stays positive.
  const Shape cube = block(ElementType::hexahedron, 1, 1, 1);
  std::vector<Vec3> dented = cube.positions;
  for (Vec3& p : dented)
    if (p == Vec3(1, 1, 1)) p = Vec3(0.3, 0.3, 0.3);
  EXPECT_EQ(of_first_element(cube, dented), Inversion::during);
}

struct Counted {
  nlohmann::json counts;
  std::size_t contacts;
};

Counted counts_of(const Shape& shape, const std::vector<Vec3>& x1) {
  const Topology topology(shape.mesh());
  const Motion motion = Motion::linear(shape.positions, x1);
  const Step step{topology, motion, test::kAllObjects};
  const StepResult result = test::run_step(step);
  return {count_inversions(step, result.contacts), result.contacts.size()};
}

/// Four coplanar points have two features with a common point, by Radon's theorem: when a tetrahedron becomes flat, a
/// vertex is in the opposite face, or two opposite edges cross. So the pipelines find all inversions of tetrahedra.
TEST(Inversion, EveryTetrahedronThatInvertsTouchesItself) {
  std::uint64_t inverting = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Shape shape = block(ElementType::tetrahedron, 3, 3, 3);
    const auto counts =
        counts_of(shape, jittered(shape.positions, 0.1 * static_cast<double>(seed % 7 + 1), seed)).counts;
    EXPECT_EQ(counts.at("examined"), 162);
    EXPECT_EQ(counts.at("inverted_at_start"), 0);
    EXPECT_EQ(counts.at("touching_inside"), counts.at("inverting")) << "seed " << seed;
    EXPECT_GE(counts.at("in_inverted"), counts.at("inverting"));
    EXPECT_EQ(counts.at("intra").get<int>(), counts.at("intra_at_start").get<int>() +
                                                 counts.at("in_inverted").get<int>() +
                                                 counts.at("at_inverted").get<int>() + counts.at("missed").get<int>());
    inverting += counts.at("inverting").get<std::uint64_t>();
  }
  EXPECT_GT(inverting, 100u);
}

/// Two blocks, as one object or as two; the second moves through the first without a change of shape.
Shape two_blocks(std::int32_t second_object) {
  Shape shape;
  shape.append(block(ElementType::tetrahedron, 2, 2, 2), 0);
  shape.append(block(ElementType::tetrahedron, 2, 2, 2).translate(Vec3(0.3, 0.2, 2.5)), second_object);
  return shape;
}

TEST(Inversion, MissesContactsBetweenElementsThatKeepTheirShape) {
  for (const std::int32_t second : {0, 1}) {
    const Shape shape = two_blocks(second);
    std::vector<Vec3> x1 = shape.positions;
    for (std::size_t v = x1.size() / 2; v < x1.size(); ++v) x1[v].z() -= 1;
    const auto [counts, contacts] = counts_of(shape, x1);
    EXPECT_GT(contacts, 0u);
    EXPECT_EQ(counts.at("inverting"), 0);
    EXPECT_EQ(counts.at("intra"), second == 0 ? contacts : 0) << "between two objects there are none";
    EXPECT_EQ(counts.at("missed"), counts.at("intra"));
  }
}

TEST(Inversion, LeavesOutContactsAtTheStart) {
  Shape shape;
  shape.append(block(ElementType::tetrahedron, 1, 1, 1), 0);
  // in the same place, but not connected
  shape.append(block(ElementType::tetrahedron, 1, 1, 1).translate(Vec3(0, 0, 1)), 0);
  const auto [counts, contacts] = counts_of(shape, shape.positions);
  EXPECT_GT(contacts, 0u);
  EXPECT_EQ(counts.at("intra"), contacts);
  EXPECT_EQ(counts.at("intra_at_start"), contacts);
  for (const char* other : {"in_inverted", "at_inverted", "missed"}) EXPECT_EQ(counts.at(other), 0) << other;
}

TEST(Inversion, TellsContactsAtAnInvertedElementFromTheRest) {
  const Shape shape = two_blocks(0);
  std::vector<Vec3> x1 = shape.positions;
  for (std::size_t v = x1.size() / 2; v < x1.size(); ++v) x1[v].z() -= 1;
  const auto before = counts_of(shape, x1).counts;
  for (std::size_t v = 0; v < x1.size() / 2; ++v)  // a corner of the first block passes through its tetrahedra
    if (x1[v] == Vec3(2, 2, 2)) x1[v] = Vec3(0.5, 0.9, 0.6);
  const auto after = counts_of(shape, x1).counts;
  EXPECT_GT(after.at("inverting").get<int>(), 0);
  EXPECT_GT(after.at("in_inverted").get<int>(), 0);
  EXPECT_GT(after.at("at_inverted").get<int>(), 0);
  EXPECT_GT(after.at("missed").get<int>(), 0);
  EXPECT_LT(after.at("missed").get<int>(), before.at("missed").get<int>());
}

}  // namespace
}  // namespace volccd
