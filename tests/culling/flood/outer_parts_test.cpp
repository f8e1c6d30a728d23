// Outer parts that are kept from step to step contain those of new ones, after any edits and motions.
#include <volccd/culling/flood/detail/outer_parts.hpp>

#include <algorithm>
#include <iterator>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/culling/flood/detail/flood_front.hpp>
#include <volccd/oracle/cases/shapes.hpp>

#include "culling/topology_editor.hpp"

namespace volccd::detail {
namespace {

/// The vertices of the outer part of each element; none if it has none.
std::vector<std::vector<Index>> parts_of(const Step& step, const OuterParts& outer) {
  std::vector<std::vector<Index>> parts(step.mesh().element_slots());
  for (Index o = 0; o < parts.size(); ++o) {
    if (!outer.table().has_part(o)) continue;
    const std::span<const Index> vertices = outer.table().part(o);
    parts[o].assign(vertices.begin(), vertices.end());
  }
  return parts;
}

/// Each part of `fresh` is in `kept`, and parts that `kept` has in addition are whole simplices.
void expect_contained(const Step& step, const OuterParts& kept, const OuterParts& fresh, const std::string& what) {
  const auto kept_parts = parts_of(step, kept), fresh_parts = parts_of(step, fresh);
  std::size_t parts = 0;
  for (Index o = 0; o < kept_parts.size(); ++o) {
    const std::span<const Index> whole = step.mesh().vertices(o);
    if (!kept_parts[o].empty() && std::ranges::equal(kept_parts[o], whole))
      EXPECT_TRUE(step.mesh().is_live(o)) << what;
    else
      EXPECT_EQ(kept_parts[o], fresh_parts[o]) << what << ", element " << o;
    parts += kept_parts[o].empty() ? 0 : 1;
  }
  EXPECT_EQ(kept.table().size(), parts) << what;
}

/// The elements whose outer parts are next to that of each element, ascending, with the common vertices.
std::vector<std::vector<std::pair<Index, std::uint32_t>>> neighbours_in(const Step& step, const VertexStars& stars,
                                                                        const PartTable& parts,
                                                                        OuterNeighbours& neighbours) {
  std::vector<std::vector<std::pair<Index, std::uint32_t>>> lists(step.mesh().element_slots());
  for (Index o = 0; o < lists.size(); ++o) {
    if (!parts.has_part(o)) continue;
    for (const OuterNeighbour& next : neighbours.of(step, stars.table(), parts, o))
      lists[o].emplace_back(next.element, next.common);
    std::ranges::sort(lists[o]);
  }
  return lists;
}

/// Which outer parts are next to each other is found again only if the table of parts has another version.
class KeptNeighbours {
 public:
  /// Returns whether the neighbours were kept.
  bool compare(const Step& step, const VertexStars& stars, const PartTable& parts, const std::string& what) {
    const bool same = std::exchange(version_, parts.topology().version()) == version_;
    OuterNeighbours fresh;
    fresh.clear(step.mesh().element_slots());
    const auto lists = neighbours_in(step, stars, parts, fresh);
    if (same) {
      EXPECT_EQ(neighbours_in(step, stars, parts, kept_), lists) << what;
    }
    kept_ = std::move(fresh);
    return same;
  }

 private:
  std::uint64_t version_ = 0;
  OuterNeighbours kept_;
};

void expect_parts_follow(const std::vector<ElementType>& added, std::uint64_t seed) {
  const Shape shape = block(ElementType::tetrahedron, 3, 3, 3);
  Topology topology(shape.mesh());
  TopologyEditor editor(topology, seed, added);
  const ObjectFilter everything;
  SerialExecutor serial;
  VertexStars kept_stars;
  OuterParts kept;
  KeptNeighbours neighbours;
  std::vector<Vec3> at = shape.positions;
  std::size_t faces = 0;
  for (int round = 0; round < 60; ++round) {
    at.resize(topology.mesh().vertex_count(), Vec3(9, 9, 9));
    const double amount = round % 4 == 3 ? 0.3 : 0.01;
    const Motion motion = Motion::linear(at, jittered(at, amount, editor.random().next()));
    const Step step{topology, motion, everything};
    VertexStars stars;
    OuterParts fresh;
    stars.update(step, serial);
    fresh.update(step, stars, serial);
    kept_stars.update(step, serial);
    if (round % 5 != 2) {  // in other steps a flood declines between both
      kept.update(step, kept_stars, serial);
      const std::string what = "seed " + std::to_string(seed) + ", round " + std::to_string(round);
      expect_contained(step, kept, fresh, what);
      neighbours.compare(step, kept_stars, kept.table(), what);
      EXPECT_TRUE(std::ranges::includes(kept.chosen_vertices(), fresh.chosen_vertices()));
      for (Index o = 0; o < topology.mesh().element_slots(); ++o)
        faces += kept.table().has_part(o) && kept.table().has_inside(o) ? 1 : 0;
    }
    if (round % 3 != 0) editor.edit_at_random();
  }
  EXPECT_GT(faces, 200u);
}

TEST(OuterParts, FollowEditsAndMotions) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    expect_parts_follow({ElementType::tetrahedron}, seed);
    expect_parts_follow({ElementType::tetrahedron, ElementType::triangle}, seed);
  }
}

/// One object for two topologies in turn: a body in which a vertex is pulled through its star, and a larger one at
/// rest, which has no marked vertices.
TEST(OuterParts, HaveNoMarksOfAnotherTopology) {
  const Shape small = block(ElementType::tetrahedron, 4, 4, 4), large = block(ElementType::tetrahedron, 5, 5, 5);
  std::vector<Vec3> pulled = small.positions;
  for (Vec3& p : pulled)
    if (p == Vec3(2, 2, 2)) p += Vec3(1.6, 0, 0);
  const Topology first(small.mesh()), second(large.mesh());
  const Motion pull = Motion::linear(small.positions, pulled), rest = Motion::linear(large.positions, large.positions);
  const ObjectFilter everything;
  SerialExecutor serial;
  VertexStars kept_stars;
  OuterParts kept;
  for (const Step& step : {Step{first, pull, everything}, Step{second, rest, everything}}) {
    VertexStars stars;
    OuterParts fresh;
    stars.update(step, serial);
    fresh.update(step, stars, serial);
    kept_stars.update(step, serial);
    kept.update(step, kept_stars, serial);
    EXPECT_EQ(kept_stars.suspects().empty(), &step.topology == &second);
    EXPECT_EQ(parts_of(step, kept), parts_of(step, fresh));
    EXPECT_EQ(kept.chosen_vertices(), fresh.chosen_vertices());
  }
}

/// An edit removes an element from the inside of a body, whose neighbours across faces are outer as wholes, because of
/// shells at their fourth vertices. Its vertices are then on the boundary, but no outer part changes.
TEST(OuterParts, HaveTheSameNeighboursAfterAnEditThatChangesNone) {
  Shape shape = block(ElementType::tetrahedron, 4, 4, 4);
  const auto deep = [&](const ElementSpec& e) {
    return std::ranges::all_of(e.vertices, [&](Index v) {
      return shape.positions[v].minCoeff() > 0.5 && shape.positions[v].maxCoeff() < 3.5;
    });
  };
  const ElementSpec inner = *std::ranges::find_if(shape.elements, deep);
  Eigen::Matrix3d edges, regular;  // with a regular hole, no star at it is suspect
  for (int k = 0; k < 3; ++k)
    edges.col(k) = shape.positions[inner.vertices[k + 1]] - shape.positions[inner.vertices[0]];
  regular << 1, 0, 1, 1, 1, 0, 0, 1, 1;
  const Eigen::Matrix3d map = (edges.determinant() * regular.determinant() > 0 ? 1 : -1) * regular * edges.inverse();
  for (Vec3& p : shape.positions) p = map * p;
  for (const ElementSpec& e : std::vector<ElementSpec>(shape.elements)) {
    std::vector<Index> others;
    std::ranges::copy_if(e.vertices, std::back_inserter(others),
                         [&](Index v) { return std::ranges::count(inner.vertices, v) == 0; });
    if (others.size() != 1) continue;
    const auto next = static_cast<Index>(shape.positions.size());
    for (const Vec3& by : {Vec3(0.2, 0.1, 0), Vec3(0.1, 0.2, 0)})
      shape.positions.push_back(shape.positions[others[0]] + by);
    shape.elements.push_back({ElementType::triangle, {others[0], next, next + 1}, {}, 0, 10000 + next});
  }
  Topology topology(shape.mesh());
  const Motion rest = Motion::linear(shape.positions, shape.positions);
  const ObjectFilter everything;
  SerialExecutor serial;
  VertexStars stars;
  OuterParts outer;
  KeptNeighbours neighbours;
  const auto compare = [&](const char* what) {
    const Step step{topology, rest, everything};
    stars.update(step, serial);
    outer.update(step, stars, serial);
    return neighbours.compare(step, stars, outer.table(), what);
  };
  EXPECT_FALSE(compare("whole"));
  EXPECT_EQ(stars.table().kind(inner.vertices[0]), StarKind::interior);
  topology.apply({{topology.mesh().find_element(inner.id)}, {}, {}});
  EXPECT_TRUE(compare("removed"));
  EXPECT_EQ(stars.table().kind(inner.vertices[0]), StarKind::ring);
  topology.apply({{}, {}, {inner}});
  EXPECT_TRUE(compare("added again"));
}

/// An edit replaces an element in its slot by one with the same vertices that belongs to another object.
TEST(OuterParts, HaveTheObjectsOfTheirElements) {
  const Shape shape = block(ElementType::tetrahedron, 1, 1, 1);
  Topology topology(shape.mesh());
  const Motion rest = Motion::linear(shape.positions, shape.positions);
  const ObjectFilter everything;
  SerialExecutor serial;
  VertexStars stars;
  OuterParts outer;
  for (const std::int32_t object : {0, 7}) {
    ElementSpec first = topology.mesh().spec(0);
    first.object = object;
    first.id = 1000 + object;
    topology.apply({{0}, {}, {first}});
    const Step step{topology, rest, everything};
    stars.update(step, serial);
    outer.update(step, stars, serial);
    const Mesh& parts = outer.table().topology().mesh();
    ASSERT_EQ(topology.mesh().object(0), object);
    for (Index part = 0; part < parts.element_slots(); ++part)
      if (parts.is_live(part)) {
        EXPECT_EQ(parts.object(part), topology.mesh().object(outer.table().simplices({part, part}).a));
      }
  }
}

/// In a slot in which an edit replaces the simplex by another one with the same face, the part is another element.
TEST(PartTable, ComparesTheSimplicesThatAreThereNow) {
  Mesh tetrahedra;
  const std::vector<std::int64_t> ids{0, 1, 2, 3, 4, 5, 6, 7};
  tetrahedra.add_vertices(ids);
  tetrahedra.add_element({.type = ElementType::tetrahedron, .vertices = {0, 1, 2, 3}, .id = 1});
  tetrahedra.add_element({.type = ElementType::tetrahedron, .vertices = {4, 5, 6, 7}, .id = 2});
  Topology topology(std::move(tetrahedra));
  const auto first_face = [](Index) -> PartTable::Kind { return 7; };
  SerialExecutor serial;
  PartTable parts;
  parts.build(topology.mesh(), first_face, serial);
  EXPECT_FALSE(parts.adjacency().adjacent(0, 1));
  const std::uint64_t version = parts.topology().version();
  topology.apply({.removed = {0}, .added = {{.type = ElementType::tetrahedron, .vertices = {0, 1, 2, 7}, .id = 3}}});
  parts.update(topology.mesh(), std::vector<Index>{0}, first_face);
  EXPECT_NE(parts.topology().version(), version);
  EXPECT_TRUE(parts.adjacency().adjacent(0, 1));
  EXPECT_FALSE(parts.topology().adjacency().adjacent(0, 1));
}

}  // namespace
}  // namespace volccd::detail
