#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cstdlib>
#include <limits>

#include <volccd/core/error.hpp>
#include <volccd/mesh/topology.hpp>
#include <volccd/mesh/topology_delta.hpp>
#include <volccd/oracle/cases/shapes.hpp>

#include "mesh/naive_features.hpp"

namespace volccd {
namespace {

// rapidcheck chooses a random seed by default. Its ranges have their full width from size 100 on; with 240, more than
// half of the cases use all element types and all vertices.
[[maybe_unused]] const bool kSeeded = setenv("RC_PARAMS", "seed=2011 max_size=240 max_success=200", 0) == 0;

using test::NaiveFeatures;

/// A polytope on distinct vertices: a bipyramid, a prism, or a flat pillow, which is degenerate but allowed.
void make_polytope(ElementSpec& element) {
  const std::vector<Index>& v = element.vertices;
  const auto face = [&](std::initializer_list<std::size_t> corners) {
    element.faces.push_back(static_cast<Index>(corners.size()));
    for (std::size_t i : corners) element.faces.push_back(v[i]);
  };
  const auto ring = [&](std::size_t begin, std::size_t n) {
    element.faces.push_back(static_cast<Index>(n));
    element.faces.insert(element.faces.end(), v.begin() + static_cast<std::ptrdiff_t>(begin),
                         v.begin() + static_cast<std::ptrdiff_t>(begin + n));
  };
  if (v.size() == 5) {
    ring(0, 5);
    ring(0, 5);
  } else if (v.size() % 2 == 1) {
    const std::size_t n = v.size() - 2;
    for (std::size_t i = 0; i < n; ++i) {
      face({i, (i + 1) % n, n});
      face({i, (i + 1) % n, n + 1});
    }
  } else {
    const std::size_t n = v.size() / 2;
    ring(0, n);
    ring(n, n);
    for (std::size_t i = 0; i < n; ++i) face({i, (i + 1) % n, n + (i + 1) % n, n + i});
  }
}

/// An element of any type on any distinct vertices, because geometry does not matter here.
ElementSpec random_element(Index vertices, std::int64_t id) {
  const auto type =
      *rc::gen::element(ElementType::triangle, ElementType::quad, ElementType::tetrahedron, ElementType::pyramid,
                        ElementType::wedge, ElementType::hexahedron, ElementType::polytope);
  const auto n = type == ElementType::polytope ? *rc::gen::element<std::size_t>(5, 6, 7, 8, 9, 12)
                                               : static_cast<std::size_t>(vertex_count(type));
  ElementSpec element;
  element.type = type;
  element.vertices = *rc::gen::unique<std::vector<Index>>(n, rc::gen::inRange<Index>(0, vertices));
  element.id = id;
  element.object = *rc::gen::inRange(0, 3);
  if (type == ElementType::polytope) make_polytope(element);
  return element;
}

/// Removes random elements, and adds random elements on old and new vertices, some with ids that have just become free.
TopologyEdit random_edit(const Mesh& mesh, std::int64_t& next_id) {
  TopologyEdit edit;
  const auto share = *rc::gen::inRange(0, 4);
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.is_live(o) && share != 0 && *rc::gen::inRange(0, 6) < share) edit.removed.push_back(o);
  if (*rc::gen::arbitrary<bool>()) std::reverse(edit.removed.begin(), edit.removed.end());
  const auto new_vertices = *rc::gen::inRange<Index>(0, 4);
  for (Index i = 0; i < new_vertices; ++i)
    edit.new_vertex_ids.push_back(mesh.vertex_ids().back() + 1 + static_cast<std::int64_t>(2 * i));
  const auto added = *rc::gen::inRange(0, 8);
  for (int i = 0; i < added; ++i) {
    const bool again = static_cast<std::size_t>(i) < edit.removed.size() && *rc::gen::arbitrary<bool>();
    const std::int64_t id = again ? mesh.element_id(edit.removed[static_cast<std::size_t>(i)]) : next_id++;
    edit.added.push_back(random_element(mesh.vertex_count() + new_vertices, id));
  }
  return edit;
}

Mesh random_mesh() {
  const auto seed = *rc::gen::inRange<std::uint64_t>(0, 100);
  Shape shape = mixed_block(1, 1);
  if (*rc::gen::arbitrary<bool>()) shape = block(ElementType::tetrahedron, 2, 2, 1);
  return permuted(shape, seed).mesh();
}

template <class Key>
std::set<Key> keys(const std::map<Key, test::Elements>& features) {
  std::set<Key> result;
  for (const auto& [key, elements] : features) result.insert(key);
  return result;
}

template <class T>
bool ascends(const std::vector<T>& list) {
  return std::adjacent_find(list.begin(), list.end(), std::greater_equal<>()) == list.end();
}

/// Checks one kind of feature of a change against sets: `before` the edit, `between` removing and adding, and `after`.
/// `slot_before` and `slot_after` give the slot of a live feature.
template <class Key, class SlotBefore, class SlotAfter>
void check_change(const std::map<Key, test::Elements>& before, const std::map<Key, test::Elements>& between,
                  const std::map<Key, test::Elements>& after, const TopologyChange& change,
                  const std::vector<Index>& removed, const std::vector<Index>& added, const std::vector<Index>& touched,
                  SlotBefore&& slot_before, SlotAfter&& slot_after) {
  const test::Elements gone = test::as_set(change.removed_elements), come = test::as_set(change.added_elements);
  const auto meets = [](const test::Elements& elements, const test::Elements& changed) {
    return std::any_of(elements.begin(), elements.end(), [&](Index o) { return changed.contains(o); });
  };
  std::set<Index> expect_removed, expect_added, expect_touched;
  for (const auto& [key, elements] : before)
    if (!between.contains(key)) expect_removed.insert(slot_before(key));
  for (const auto& [key, elements] : after) {
    if (!between.contains(key)) expect_added.insert(slot_after(key));
    if (meets(elements, come) || (before.contains(key) && meets(before.at(key), gone)))
      expect_touched.insert(slot_after(key));
    // A feature that exists before, during and after the edit keeps its slot.
    if (between.contains(key)) RC_ASSERT(slot_before(key) == slot_after(key));
  }
  RC_ASSERT(ascends(removed));
  RC_ASSERT(ascends(added));
  RC_ASSERT(ascends(touched));
  RC_ASSERT(test::as_set(removed) == expect_removed);
  RC_ASSERT(test::as_set(added) == expect_added);
  RC_ASSERT(test::as_set(touched) == expect_touched);
}

bool naive_shared(const NaiveFeatures& features, const Mesh& mesh) {
  for (const auto& [v, elements] : features.vertices)
    for (Index o : elements)
      if (mesh.object(o) != mesh.object(*elements.begin())) return true;
  return false;
}

bool adjacency_is_right(const Topology& topology) {
  const Mesh& mesh = topology.mesh();
  for (Index a = 0; a < mesh.element_slots(); ++a)
    for (Index b = 0; b < mesh.element_slots(); ++b) {
      if (!mesh.is_live(a) || !mesh.is_live(b)) continue;
      const auto v = mesh.vertices(a), w = mesh.vertices(b);
      if (topology.adjacency().adjacent(a, b) !=
          (std::find_first_of(v.begin(), v.end(), w.begin(), w.end()) != v.end()))
        return false;
    }
  return true;
}

/// The expected effect of an edit on the features, computed step by step on sets.
void check_edit(Topology& topology, const TopologyEdit& edit) {
  const EdgeSet edge_set = topology.features().edge_set();
  const NaiveFeatures before = test::naive_features(topology.mesh(), edge_set);
  Mesh removed_only = topology.mesh();
  for (Index o : edit.removed) removed_only.remove_element(o);
  const NaiveFeatures between = test::naive_features(removed_only, edge_set);
  const Features old = topology.features();
  std::vector<ElementSpec> added = edit.added;

  const TopologyChange& change = topology.apply(edit);

  const Features& now = topology.features();
  const NaiveFeatures after = test::naive_features(topology.mesh(), edge_set);
  RC_ASSERT(change.version == topology.version());
  RC_ASSERT(ascends(change.removed_elements));
  RC_ASSERT(ascends(change.added_elements));
  RC_ASSERT(test::as_set(change.removed_elements) == test::as_set(edit.removed));
  std::set<Index> slots;
  for (const ElementSpec& element : added) {
    const Index o = topology.mesh().find_element(element.id);
    RC_ASSERT(o != kNone);
    RC_ASSERT(std::ranges::equal(topology.mesh().vertices(o), element.vertices));
    slots.insert(o);
  }
  RC_ASSERT(test::as_set(change.added_elements) == slots);
  const FeatureChange& f = change.features;
  const auto same = [](Index v) { return v; };
  check_change(before.vertices, between.vertices, after.vertices, change, f.removed_vertices, f.added_vertices,
               f.touched_vertices, same, same);
  check_change(
      before.edges, between.edges, after.edges, change, f.removed_edges, f.added_edges, f.touched_edges,
      [&](const test::Edge& e) { return old.find_edge(e[0], e[1]); },
      [&](const test::Edge& e) { return now.find_edge(e[0], e[1]); });
  check_change(
      before.triangles, between.triangles, after.triangles, change, f.removed_triangles, f.added_triangles,
      f.touched_triangles, [&](const test::Triangle& t) { return old.find_triangle(t[0], t[1], t[2]); },
      [&](const test::Triangle& t) { return now.find_triangle(t[0], t[1], t[2]); });
  RC_ASSERT(topology.objects_share_vertices() == naive_shared(after, topology.mesh()));
}

void check_random_edits(EdgeSet edge_set) {
  Topology topology(random_mesh(), edge_set);
  std::int64_t next_id = 1000;
  const auto edits = *rc::gen::inRange(1, 6);
  for (int i = 0; i < edits; ++i) {
    check_edit(topology, random_edit(topology.mesh(), next_id));
    const std::string problem = test::inconsistency(topology.mesh(), topology.features());
    if (!problem.empty()) RC_FAIL(problem);
    RC_ASSERT(adjacency_is_right(topology));
    Features rebuilt(edge_set);
    rebuilt.build(topology.mesh());
    RC_ASSERT(test::contents(rebuilt) == test::contents(topology.features()));

    std::vector<const TopologyChange*> changes;
    RC_ASSERT(topology.changes_since(topology.version(), changes));
    RC_ASSERT(changes.empty());
    std::vector<Index> slots = topology.apply({}).removed_elements;  // an empty edit changes nothing
    RC_ASSERT(slots.empty());
    RC_ASSERT(test::contents(rebuilt) == test::contents(topology.features()));
  }
}

TEST(Topology, EditedEqualsRebuiltTriangulated) {
  EXPECT_TRUE(rc::check([] { check_random_edits(EdgeSet::triangulated); }));
}

TEST(Topology, EditedEqualsRebuiltPolytope) {
  EXPECT_TRUE(rc::check([] { check_random_edits(EdgeSet::polytope); }));
}

TEST(Topology, EditedEqualsRebuiltWithoutEdges) {
  EXPECT_TRUE(rc::check([] { check_random_edits(EdgeSet::none); }));
}

TEST(Topology, ADeltaListsWhatChangedSinceItWasConfirmed) {
  EXPECT_TRUE(rc::check([] {
    using Extent = TopologyDelta::Extent;
    Topology topology(random_mesh());
    TopologyDelta delta;
    RC_ASSERT(delta.sync(topology) == Extent::everything);
    std::uint64_t seen = topology.version();
    std::int64_t next_id = 1000;
    std::vector<const TopologyChange*> changes;
    for (int round = 0; round < 6; ++round) {
      const auto confirmed = *rc::gen::arbitrary<bool>();
      if (confirmed) delta.confirm();
      const auto edits = *rc::gen::inRange<std::size_t>(0, Topology::kHistory + 3);
      std::set<Index> slots;
      for (std::size_t i = 0; i < edits; ++i) {
        const TopologyChange& change = topology.apply(random_edit(topology.mesh(), next_id));
        slots.insert(change.removed_elements.begin(), change.removed_elements.end());
        slots.insert(change.added_elements.begin(), change.added_elements.end());
      }
      RC_ASSERT(topology.changes_since(seen, changes) == (edits <= Topology::kHistory));
      RC_ASSERT(changes.size() == (edits <= Topology::kHistory ? edits : 0));
      if (!changes.empty()) RC_ASSERT(changes.back()->version == topology.version());
      const Extent extent = delta.sync(topology);
      RC_ASSERT(extent == (!confirmed || edits > Topology::kHistory ? Extent::everything
                           : edits == 0                             ? Extent::none
                                                                    : Extent::edits));
      if (extent != Extent::everything) {
        RC_ASSERT(delta.changes() == changes);
        RC_ASSERT(std::ranges::equal(delta.changed_slots(), slots));
      }
      seen = topology.version();
    }
    delta.confirm();
    const Topology other(random_mesh());
    RC_ASSERT(delta.sync(other) == Extent::everything);
  }));
}

TEST(Topology, VersionsAreDistinctAndForeignOnesAreNoticed) {
  Topology a(block(ElementType::hexahedron, 2, 1, 1).mesh()), b(block(ElementType::hexahedron, 2, 1, 1).mesh());
  std::set<std::uint64_t> versions = {0, a.version(), b.version()};
  std::vector<const TopologyChange*> changes;
  for (std::size_t i = 0; i < 2 * Topology::kHistory; ++i) {
    a.apply({});
    b.apply({});
    versions.insert(a.version());
    versions.insert(b.version());
    EXPECT_FALSE(a.changes_since(b.version(), changes));
    EXPECT_TRUE(changes.empty());
    EXPECT_FALSE(b.changes_since(a.version(), changes));
    EXPECT_FALSE(a.changes_since(0, changes));
  }
  EXPECT_EQ(versions.size(), 3 + 4 * Topology::kHistory);
}

TEST(Topology, SharedVerticesAreCountedThroughEdits) {
  Shape shape = block(ElementType::hexahedron, 3, 1, 1);
  shape.elements[1].object = 1;
  Topology topology(shape.mesh());
  EXPECT_TRUE(topology.objects_share_vertices());
  const Index middle = topology.mesh().find_element(shape.elements[1].id);
  topology.apply({{middle}, {}, {}});
  EXPECT_FALSE(topology.objects_share_vertices());
  topology.apply({{}, {}, {shape.elements[1]}});
  EXPECT_TRUE(topology.objects_share_vertices());
  ElementSpec same = shape.elements[1];
  same.object = 0;
  topology.apply({{topology.mesh().find_element(same.id)}, {}, {same}});
  EXPECT_FALSE(topology.objects_share_vertices());
  // A mesh that is empty at the beginning.
  Mesh none;
  none.add_vertices(static_cast<Index>(shape.positions.size()));
  Topology grown(none);
  grown.apply({{}, {}, {shape.elements[0]}});
  EXPECT_FALSE(grown.objects_share_vertices());
  grown.apply({{}, {}, {shape.elements[1]}});
  EXPECT_TRUE(grown.objects_share_vertices());
}

struct BadEdit {
  const char* dataset;
  std::int64_t index;
  TopologyEdit edit;
};

std::vector<BadEdit> bad_edits(const Mesh& mesh, Index empty_slot) {
  const auto tetrahedron = [](std::vector<Index> vertices, std::int64_t id) {
    ElementSpec element;
    element.type = ElementType::tetrahedron;
    element.vertices = std::move(vertices);
    element.id = id;
    return element;
  };
  const Index n = mesh.vertex_count();
  const std::int64_t last = mesh.vertex_ids().back();
  const ElementSpec good = tetrahedron({0, 1, 2, 3}, 100);
  return {{"removed", 1, {{0, mesh.element_slots()}, {}, {}}},
          {"removed", 0, {{kNone}, {}, {}}},
          {"removed", 2, {{0, 1, empty_slot}, {}, {}}},
          {"removed", 3, {{4, 2, 0, 2}, {}, {}}},
          {"new_vertex_ids", 0, {{0}, {last}, {good}}},
          {"new_vertex_ids", 1, {{0}, {last + 5, last + 5}, {good}}},
          {"new_vertex_ids", 2, {{0}, {last + 5, last + 6, std::numeric_limits<std::int64_t>::min()}, {good}}},
          {"added", 1, {{0}, {}, {good, tetrahedron({0, 1, 2, n}, 101)}}},
          {"added", 1, {{0}, {last + 1}, {good, tetrahedron({0, 1, 2, n + 1}, 101)}}},
          {"added", 0, {{0}, {}, {tetrahedron({0, 1, 2}, 101)}}},
          {"added", 2, {{0}, {}, {good, tetrahedron({0, 1, 2, 3}, 101), tetrahedron({0, 1, 2, 3}, 100)}}},
          {"added", 0, {{0}, {}, {tetrahedron({0, 1, 2, 3}, mesh.element_id(1))}}},
          {"added",
           1,
           {{0}, {}, {tetrahedron({0, 1, 2, 3}, mesh.element_id(0)), tetrahedron({0, 1, 2, 3}, mesh.element_id(0))}}}};
}

TEST(Topology, RefusesBadEditsAndChangesNothing) {
  Topology topology(block(ElementType::tetrahedron, 2, 1, 1).mesh());
  topology.apply({{3}, {}, {}});
  const std::uint64_t version = topology.version();
  const NaiveFeatures features = test::contents(topology.features());
  for (const BadEdit& bad : bad_edits(topology.mesh(), 3)) {
    try {
      topology.apply(bad.edit);
      FAIL() << bad.dataset << "[" << bad.index << "] was taken";
    } catch (const InputError& error) {
      EXPECT_EQ(error.source(), "edit") << error.what();
      EXPECT_EQ(error.dataset(), bad.dataset) << error.what();
      EXPECT_EQ(error.index(), bad.index) << error.what();
    }
    EXPECT_EQ(topology.version(), version);
    EXPECT_EQ(topology.mesh().element_count(), 11u);
    EXPECT_EQ(topology.mesh().vertex_count(), 12u);
    EXPECT_EQ(test::contents(topology.features()), features);
  }
  EXPECT_EQ(test::inconsistency(topology.mesh(), topology.features()), "");
}

}  // namespace
}  // namespace volccd
