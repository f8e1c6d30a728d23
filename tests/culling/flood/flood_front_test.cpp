// What a flood concludes about positions at t = 0.
#include <volccd/culling/flood/detail/flood_front.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/oracle/cases/shapes.hpp>

#include "culling/exact_contacts.hpp"

namespace volccd::detail {
namespace {

const ObjectFilter kAnyObjects;

/// Two tetrahedra with one to three common vertices, the first ones, at random positions.
Shape adjacent_pair(Random& random, Index common) {
  Shape shape;
  ElementSpec a{ElementType::tetrahedron, {0, 1, 2, 3}, {}, 0, 0}, b = a;
  b.id = 1;
  for (Index i = common; i < 4; ++i) b.vertices[i] = 4 + i - common;
  for (ElementSpec* e : {&a, &b})
    std::rotate(e->vertices.begin(), e->vertices.begin() + static_cast<std::ptrdiff_t>(random.below(4)),
                e->vertices.end());
  shape.elements = {a, b};
  for (Index v = 0; v < 8 - common; ++v)
    shape.positions.emplace_back(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
  return shape;
}

double volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) { return (b - a).cross(c - a).dot(d - a); }

/// Whether one of some points of the first tetrahedron is inside the second one.
bool overlap(const Shape& shape, Random& random) {
  const auto at = [&](std::size_t e, std::size_t i) { return shape.positions[shape.elements[e].vertices[i]]; };
  const double whole = volume(at(1, 0), at(1, 1), at(1, 2), at(1, 3));
  for (int sample = 0; sample < 100; ++sample) {
    double weights[4], sum = 0;
    for (double& w : weights) sum += w = -std::log(random.uniform(1e-9, 1));
    Vec3 p = Vec3::Zero();
    for (std::size_t i = 0; i < 4; ++i) p += weights[i] / sum * at(0, i);
    bool inside = true;
    for (std::size_t i = 0; i < 4; ++i) {
      Vec3 corners[4] = {at(1, 0), at(1, 1), at(1, 2), at(1, 3)};
      corners[i] = p;
      inside = inside && volume(corners[0], corners[1], corners[2], corners[3]) / whole > 1e-6;
    }
    if (inside) return true;
  }
  return false;
}

TEST(FloodFront, AdjacentElementsThatTouchElsewhereAreNotApart) {
  Random random(1);
  SerialExecutor serial;
  for (const double separation : {0.0, 0.02}) {
    std::size_t apart = 0, touching = 0;
    for (int trial = 0; trial < 600; ++trial) {
      const Shape shape = adjacent_pair(random, 1 + static_cast<Index>(trial % 3));
      const Topology topology(shape.mesh());
      const Motion rest = Motion::linear(shape.positions, shape.positions);
      const Step step{topology, rest, kAnyObjects, separation};
      StarTable table;
      table.update(topology, serial);
      PartTable parts;
      parts.build(
          topology.mesh(), [](Index) { return PartTable::kWhole; }, serial);
      PairSet seen;
      std::vector<ElementPair> out;
      bool touches = false;
      visit_touching(step, [&](std::span<const Index> a, std::span<const Index> b) {
        const auto has = [](std::span<const Index> list, Index o) {
          return std::find(list.begin(), list.end(), o) != list.end();
        };
        touches = touches || (has(a, 0) && has(b, 1)) || (has(a, 1) && has(b, 0));
      });
      touches = touches || overlap(shape, random);
      const bool found = FloodFront(step, table, parts, seen, out).apart_at_start({0, 1});
      EXPECT_FALSE(found && touches) << trial << ", separation " << separation;
      apart += found ? 1 : 0;
      touching += touches ? 1 : 0;
    }
    EXPECT_GT(apart, 100u) << separation;
    EXPECT_GT(touching, 100u) << separation;
  }
}

/// A tetrahedron without an outer part, and a vertex of another one on each side of its box.
TEST(FloodFront, ProposesElementsWhoseBoxesContainAVertexWithTheSeparation) {
  SerialExecutor serial;
  for (int side = 0; side < 6; ++side)
    for (const double distance : {-0.01, 0.09, 0.11}) {
      Shape shape;
      shape.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
      Vec3 at(0.5, 0.5, 0.5), out = Vec3::Zero();
      out[side / 2] = side % 2 == 0 ? -1 : 1;
      at[side / 2] = (side % 2 == 0 ? 0 : 1) + distance * out[side / 2];
      for (const Vec3& p : {Vec3(0, 0, 0), Vec3(2, 3, 0), Vec3(0, 2, 3), Vec3(3, 0, 2)})
        shape.positions.push_back(at + (p.norm() > 0 ? Vec3(p + 5 * out) : p));
      shape.elements = {{ElementType::tetrahedron, {0, 1, 2, 3}, {}, 0, 0},
                        {ElementType::tetrahedron, {4, 5, 6, 7}, {}, 0, 1}};
      const Topology topology(shape.mesh());
      PartTable parts;
      parts.build(
          topology.mesh(), [](Index o) { return o == 0 ? PartTable::kNoPart : PartTable::kWhole; }, serial);
      const Motion rest = Motion::linear(shape.positions, shape.positions);
      const Step step{topology, rest, kAnyObjects, 0.1};
      StarTable table;
      table.update(topology, serial);
      PairSet seen;
      std::vector<ElementPair> proposed;
      StartScratch scratch;
      const std::vector<Index> chosen = {4};
      FloodFront(step, table, parts, seen, proposed).propose_containing(chosen, scratch, serial);
      EXPECT_EQ(proposed.size(), distance < 0.1 ? 1u : 0u) << side << ' ' << distance;
    }
}

/// An element next to the second one at that vertex is proposed if the box contains it, with the separation.
TEST(FloodFront, ProposesNextOuterPartsWhereTheyMeetABoxWithTheSeparation) {
  SerialExecutor serial;
  for (int side = 0; side < 6; ++side)
    for (const double distance : {-0.01, 0.09, 0.11}) {
      Shape shape;
      shape.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
      Vec3 at(0.5, 0.5, 0.5), out = Vec3::Zero();
      out[side / 2] = side % 2 == 0 ? -1 : 1;
      at[side / 2] = (side % 2 == 0 ? 0 : 1) + distance * out[side / 2];
      for (const Vec3& p : {Vec3(0, 0, 0), Vec3(2, 3, 0), Vec3(0, 2, 3), Vec3(3, 0, 2), Vec3(-2, -3, 0),
                            Vec3(0, -2, -3), Vec3(-3, 0, -2)})
        shape.positions.push_back(at + (p.norm() > 0 ? Vec3(p + 5 * out) : p));
      shape.elements = {{ElementType::tetrahedron, {0, 1, 2, 3}, {}, 0, 0},
                        {ElementType::tetrahedron, {4, 5, 6, 7}, {}, 0, 1},
                        {ElementType::tetrahedron, {4, 8, 9, 10}, {}, 0, 2}};
      const Topology topology(shape.mesh());
      PartTable parts;
      parts.build(
          topology.mesh(), [](Index o) { return o == 0 ? PartTable::kNoPart : PartTable::kWhole; }, serial);
      const Motion rest = Motion::linear(shape.positions, shape.positions);
      const Step step{topology, rest, kAnyObjects, 0.1};
      StarTable table;
      table.update(topology, serial);
      PairSet seen;
      std::vector<ElementPair> proposed;
      StartScratch scratch;
      scratch.neighbours.clear(3);
      FloodFront(step, table, parts, seen, proposed).propose_neighbours_at_start({0, 1}, scratch);
      EXPECT_EQ(proposed.size(), distance < 0.1 ? 1u : 0u) << side << ' ' << distance;
    }
}

/// One tetrahedron without a boundary face is outer as a whole. It is next to all outer parts at its vertices, also to
/// those with which it has a single vertex in common.
TEST(FloodFront, OuterPartsAreNextToWholeElementsAtOneVertex) {
  SerialExecutor serial;
  const Shape shape = block(ElementType::tetrahedron, 3, 3, 3);
  const Topology topology(shape.mesh());
  const Mesh& mesh = topology.mesh();
  StarTable table;
  table.update(topology, serial);
  const auto boundary_part = [&](Index o) {
    std::uint8_t part = PartTable::kNoPart;
    visit_faces(mesh, o, [&](std::span<const Index> face, std::size_t number) {
      if (table.faces(o)[number] != FaceKind::boundary) return;
      const std::span<const Index> vertices = mesh.vertices(o);
      std::uint8_t bits = 0;
      for (std::size_t i = 0; i < 4; ++i)
        if (std::find(face.begin(), face.end(), vertices[i]) != face.end()) bits |= static_cast<std::uint8_t>(1u << i);
      part = part == PartTable::kNoPart ? bits : PartTable::kWhole;
    });
    return part;
  };
  std::vector<Index> slots(mesh.element_slots());
  std::iota(slots.begin(), slots.end(), Index{0});
  const Motion rest = Motion::linear(shape.positions, shape.positions);
  std::size_t at_one_vertex = 0;
  for (Index whole = 0; whole < mesh.element_slots(); ++whole) {
    if (boundary_part(whole) != PartTable::kNoPart) continue;
    PartTable parts;
    parts.build(
        mesh, [&](Index o) { return o == whole ? PartTable::kWhole : boundary_part(o); }, serial);
    const Step step{topology, rest, kAnyObjects};
    OuterNeighbours neighbours;
    neighbours.clear(mesh.element_slots());
    const std::span<const Index> of_whole = mesh.vertices(whole);
    for (const Index o : slots) {
      if (!parts.has_part(o) || !parts.has_inside(o)) continue;
      const std::span<const Index> part = parts.part(o);
      const auto common = std::count_if(part.begin(), part.end(), [&](Index v) {
        return std::find(of_whole.begin(), of_whole.end(), v) != of_whole.end();
      });
      const std::span<const OuterNeighbour> next = neighbours.of(step, table, parts, o);
      const bool listed = std::any_of(next.begin(), next.end(), [&](const auto& n) { return n.element == whole; });
      EXPECT_EQ(listed, common > 0) << whole << ' ' << o;
      at_one_vertex += common == 1 ? 1 : 0;
    }
  }
  EXPECT_GT(at_one_vertex, 10u);
}

}  // namespace
}  // namespace volccd::detail
