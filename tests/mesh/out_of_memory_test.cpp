// Changes have no effect if memory runs out: every single allocation of a change fails once, and the visible state
// stays as it was.
#include <set>
#include <utility>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/mesh/incidence_pool.hpp>
#include <volccd/mesh/topology.hpp>
#include <volccd/mesh/topology_delta.hpp>
#include <volccd/oracle/cases/shapes.hpp>

#include "mesh/naive_features.hpp"
#include "support/allocations.hpp"

namespace volccd {
namespace {

using test::Memory;

constexpr std::int64_t kIdEnd = 1200;  ///< elements have smaller ids

/// The visible state of an object, as numbers.
using Snapshot = std::vector<std::int64_t>;

template <class Range>
void take(Snapshot& all, const Range& range) {
  all.push_back(static_cast<std::int64_t>(std::size(range)));
  all.insert(all.end(), std::begin(range), std::end(range));
}

Snapshot snapshot(const Mesh& mesh) {
  Snapshot all = {mesh.element_slots(), mesh.element_count()};
  take(all, mesh.vertex_ids());
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    all.push_back(static_cast<std::int64_t>(mesh.type(o)));
    if (!mesh.is_live(o)) continue;
    all.insert(all.end(), {mesh.object(o), mesh.element_id(o), mesh.find_element(mesh.element_id(o))});
    take(all, mesh.vertices(o));
    take(all, mesh.polytope_faces(o));
  }
  for (std::int64_t id = -10; id < kIdEnd; ++id) all.push_back(mesh.find_element(id));
  return all;
}

Snapshot snapshot(const Features& features, Index element_slots) {
  Snapshot all = {features.vertex_slots(), features.edge_slots(), features.triangle_slots(),
                  features.vertex_count(), features.edge_count(), features.triangle_count()};
  for (Index v = 0; v < features.vertex_slots(); ++v) {
    take(all, features.vertex_elements(v));
    all.push_back(features.first_element_of_vertex(v));
  }
  for (Index e = 0; e < features.edge_slots(); ++e) {
    take(all, features.edge_elements(e));
    all.push_back(features.first_element_of_edge(e));
    if (features.edge_elements(e).empty()) continue;
    take(all, features.edge(e));
    all.push_back(features.find_edge(features.edge(e)[0], features.edge(e)[1]));
  }
  for (Index f = 0; f < features.triangle_slots(); ++f) {
    take(all, features.triangle_elements(f));
    all.push_back(features.first_element_of_triangle(f));
    if (features.triangle_elements(f).empty()) continue;
    const auto& t = features.triangle(f);
    take(all, t);
    all.push_back(features.find_triangle(t[0], t[1], t[2]));
  }
  for (Index o = 0; o < element_slots; ++o) {
    take(all, features.element_edges(o));
    take(all, features.element_triangles(o));
    take(all, features.own_edges(o));
    take(all, features.own_triangles(o));
  }
  return all;
}

/// Without versions, because these differ between topologies.
Snapshot snapshot(const Topology& topology) {
  const Mesh& mesh = topology.mesh();
  Snapshot all = snapshot(mesh);
  const Snapshot features = snapshot(topology.features(), topology.mesh().element_slots());
  all.insert(all.end(), features.begin(), features.end());
  all.push_back(topology.objects_share_vertices());
  for (Index a = 0; a < mesh.element_slots(); ++a) {
    if (!mesh.is_live(a)) continue;
    take(all, topology.adjacency().vertices(a));
    std::int64_t bits = 0;
    for (Index b = a; b < mesh.element_slots(); ++b) {
      if (mesh.is_live(b)) bits = 2 * bits + topology.adjacency().adjacent(a, b);
      if ((b - a) % 62 == 61) all.push_back(std::exchange(bits, 0));
    }
    all.push_back(bits);
  }
  return all;
}

Snapshot snapshot(const TopologyChange& change) {
  Snapshot all;
  const FeatureChange& f = change.features;
  for (const auto* list : {&change.removed_elements, &change.added_elements, &f.removed_vertices, &f.removed_edges,
                           &f.removed_triangles, &f.added_vertices, &f.added_edges, &f.added_triangles,
                           &f.touched_vertices, &f.touched_edges, &f.touched_triangles})
    take(all, *list);
  return all;
}

/// Random elements are removed, some of the removed ones are added again, and others are added on old and new vertices.
class Edits {
 public:
  Edits(const Shape& shape, std::uint64_t seed) : shape_(shape), random_(seed) {}

  TopologyEdit next(const Mesh& mesh) {
    TopologyEdit edit;
    for (std::uint64_t i = random_.below(5); i != 0; --i)
      edit.new_vertex_ids.push_back(mesh.vertex_ids().back() + static_cast<std::int64_t>(6 - i));
    const std::uint64_t share = random_.below(4);  // out of five; sometimes none
    std::set<std::int64_t> there;
    for (Index o = 0; o < mesh.element_slots(); ++o) {
      if (!mesh.is_live(o)) continue;
      if (random_.below(5) < share)
        edit.removed.push_back(o);
      else
        there.insert(mesh.element_id(o));
    }
    for (ElementSpec element : shape_.elements)
      if (!there.contains(element.id) && random_.below(2) == 0) {
        element.object = static_cast<std::int32_t>(random_.below(2));
        edit.added.push_back(element);
      }
    const Index vertices = mesh.vertex_count() + static_cast<Index>(edit.new_vertex_ids.size());
    for (std::uint64_t i = random_.below(6); i != 0; --i) {
      std::set<Index> corners;
      while (corners.size() < 4)
        corners.insert(vertices - 1 - static_cast<Index>(random_.below(std::min<Index>(vertices, 30))));
      edit.added.push_back(
          {.type = ElementType::tetrahedron, .vertices = {corners.begin(), corners.end()}, .id = next_id_++});
      EXPECT_LT(next_id_, kIdEnd);
    }
    random_.shuffle(edit.added);
    return edit;
  }

 private:
  const Shape& shape_;
  Random random_;
  std::int64_t next_id_ = 1000;
};

/// `start` with hexahedra and prisms of 8 to 14 vertices.
Shape with_large_elements(const Shape& start) {
  Shape shape = start;
  Random random(2);
  for (std::int64_t id = 500; id < 530; ++id) {
    ElementSpec element{.type = id % 3 == 0 ? ElementType::hexahedron : ElementType::polytope, .id = id};
    const std::size_t n = id % 3 == 0 ? 4 : 4 + random.below(4);
    std::set<Index> chosen;
    while (chosen.size() < 2 * n) chosen.insert(static_cast<Index>(random.below(start.positions.size())));
    element.vertices.assign(chosen.begin(), chosen.end());
    if (element.type == ElementType::polytope) {
      for (const std::size_t ring : {std::size_t{0}, n}) {
        element.faces.push_back(static_cast<Index>(n));
        for (std::size_t k = 0; k < n; ++k) element.faces.push_back(element.vertices[ring + k]);
      }
      for (std::size_t k = 0; k < n; ++k) {
        const std::size_t next = (k + 1) % n;
        element.faces.push_back(4);
        for (const std::size_t corner : {k, next, n + next, n + k}) element.faces.push_back(element.vertices[corner]);
      }
    }
    shape.elements.push_back(element);
  }
  return shape;
}

void check_edits(const Shape& start, const Shape& shape, std::size_t expected_failures) {
  for (const EdgeSet edge_set : {EdgeSet::triangulated, EdgeSet::polytope}) {
    Topology topology(start.mesh(), edge_set), undisturbed(start.mesh(), edge_set);
    Edits edits(shape, 5);
    std::size_t failures = 0;
    for (int i = 0; i < 16; ++i) {
      const TopologyEdit edit = edits.next(topology.mesh());
      const std::uint64_t version = topology.version();
      const Snapshot before = snapshot(topology);
      const TopologyChange* change = nullptr;
      std::vector<const TopologyChange*> changes;
      failures += test::fail_allocations(
          i % 2 == 0 ? Memory::lacks_once : Memory::stays_out, [&] { change = &topology.apply(edit); },
          [&] {
            ASSERT_TRUE(snapshot(topology) == before) << "edit " << i;
            ASSERT_EQ(topology.version(), version);
            ASSERT_TRUE(topology.changes_since(version, changes) && changes.empty());
          });
      ASSERT_NE(change, nullptr);
      ASSERT_EQ(test::inconsistency(topology.mesh(), topology.features()), "");
      EXPECT_TRUE(snapshot(undisturbed.apply(edit)) == snapshot(*change)) << "edit " << i;
      EXPECT_TRUE(snapshot(undisturbed) == snapshot(topology)) << "edit " << i;
      EXPECT_TRUE(topology.changes_since(version, changes));
      EXPECT_EQ(changes, std::vector<const TopologyChange*>{change});
    }
    EXPECT_GT(failures, expected_failures);
  }
}

TEST(OutOfMemory, AnEditOfATopologyIsMadeAsAWholeOrNotAtAll) {
  const Shape shape = permuted(mixed_block(3, 3), 1);
  check_edits(shape, shape, 500);
}

TEST(OutOfMemory, AnEditThatBringsLargerElementsIsMadeAsAWholeOrNotAtAll) {
  const Shape small = block(ElementType::tetrahedron, 3, 3, 2);
  check_edits(small, with_large_elements(small), 500);
}

TEST(OutOfMemory, AfterAFailureADeltaListsEverything) {
  using Extent = TopologyDelta::Extent;
  const Shape shape = permuted(mixed_block(2, 2), 1);
  Topology topology(shape.mesh());
  Edits edits(shape, 7);
  TopologyDelta delta;
  std::size_t failures = 0;
  Extent extent = Extent::none;
  for (int i = 0; i < 4; ++i) {
    const std::size_t before = failures;
    failures += test::fail_allocations(
        Memory::lacks_once, [&] { extent = delta.sync(topology); }, [] {});
    EXPECT_EQ(extent, i == 0 || failures != before ? Extent::everything : Extent::edits) << i;
    delta.confirm();
    topology.apply(edits.next(topology.mesh()));
  }
  EXPECT_GT(failures, 0u);
}

TEST(OutOfMemory, AMeshTakesAnElementAsAWholeOrNotAtAll) {
  const Shape shape = mixed_block(1, 1);
  Mesh mesh;
  std::size_t failures = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Snapshot before = snapshot(mesh);
    failures += test::fail_allocations(
        Memory::lacks_once, [&] { mesh.add_vertices(static_cast<Index>(shape.positions.size())); },
        [&] { ASSERT_TRUE(snapshot(mesh) == before); });
  }
  Random random(3);
  std::vector<Index> there;
  for (int i = 0; i < 200; ++i) {
    const Snapshot before = snapshot(mesh);
    const auto unchanged = [&] { ASSERT_TRUE(snapshot(mesh) == before) << i; };
    const Memory memory = i % 2 == 0 ? Memory::lacks_once : Memory::stays_out;
    if (there.size() > 2 && random.below(3) == 0) {
      const std::size_t k = random.below(there.size());
      failures += test::fail_allocations(
          memory, [&] { mesh.remove_element(there[k]); }, unchanged);
      there.erase(there.begin() + static_cast<std::ptrdiff_t>(k));
    } else {
      ElementSpec element = shape.elements[random.below(shape.elements.size())];
      element.id = i;
      Index slot = kNone;
      failures += test::fail_allocations(
          memory, [&] { slot = mesh.add_element(element); }, unchanged);
      there.push_back(slot);
    }
  }
  EXPECT_GT(failures, 50u);
}

TEST(OutOfMemory, APoolKeepsItsListsAndIsCompactedLater) {
  detail::IncidencePool pool;
  pool.extend(40);
  std::vector<std::vector<Index>> reference(40);
  Random random(4);
  std::size_t failures = 0;
  for (int i = 0; i < 3000; ++i) {
    const std::size_t k = random.below(reference.size());
    std::vector<Index> values;
    for (std::uint64_t n = random.below(random.below(8) == 0 ? 200 : 12), v = 0; n != 0; --n)
      values.push_back(static_cast<Index>(v += 1 + random.below(9)));
    failures += test::fail_allocations(
        i % 2 == 0 ? Memory::lacks_once : Memory::stays_out,
        [&] {
          pool.assign(k, values);
          pool.compact_if_sparse();
        },
        [&] { ASSERT_TRUE(std::ranges::equal(pool[k], reference[k])) << i; });
    reference[k] = values;
    for (std::size_t j = 0; j < reference.size() && i % 50 == 0; ++j) {
      ASSERT_TRUE(std::ranges::equal(pool[j], reference[j])) << i;
    }
  }
  EXPECT_GT(failures, 0u);
}

}  // namespace
}  // namespace volccd
