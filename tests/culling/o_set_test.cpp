// O-Sets in situations that the enumeration on regular meshes does not reach: random elements on few vertices (any
// number of elements at a feature, non-manifold everywhere), and incremental updates on larger meshes.
#include <algorithm>
#include <array>
#include <memory>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/culling/o_set.hpp>
#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/query/test_block.hpp>

namespace volccd {
namespace {

/// A test identified by its kind and vertices (test_vertices()).
using Key = std::array<Index, 5>;

Key key(const Features& features, FeatureKind kind, FeaturePair pair) {
  const auto v = test_vertices(features, kind, pair);
  return {kind == FeatureKind::ee, v[0], v[1], v[2], v[3]};
}

/// All pairs, in ascending order. Fails if a pair is repeated, shares a vertex, or has dead features, or if counts() is
/// wrong.
std::vector<Key> keys(const OSet& set, const Features& features) {
  TestBatch batch;
  for (std::size_t b = 0; b < set.blocks(); ++b) {
    const std::size_t before = batch.vf.size() + batch.ee.size();
    set.append(b, batch);
    EXPECT_LE(batch.vf.size() + batch.ee.size() - before, OSet::kBlockPairs);
  }
  EXPECT_EQ(set.counts(), (OSetCounts{batch.vf.size(), batch.ee.size()}));
  std::vector<Key> keys;
  for (const FeaturePair p : batch.vf) {
    EXPECT_FALSE(features.vertex_elements(p.a).empty() || features.triangle_elements(p.b).empty());
    EXPECT_TRUE(is_test(features, FeatureKind::vf, p));
    keys.push_back(key(features, FeatureKind::vf, p));
  }
  for (const FeaturePair p : batch.ee) {
    EXPECT_LT(p.a, p.b);
    EXPECT_FALSE(features.edge_elements(p.a).empty() || features.edge_elements(p.b).empty());
    EXPECT_TRUE(is_test(features, FeatureKind::ee, p));
    keys.push_back(key(features, FeatureKind::ee, p));
  }
  std::sort(keys.begin(), keys.end());
  EXPECT_EQ(std::adjacent_find(keys.begin(), keys.end()), keys.end()) << "a pair comes twice";
  return keys;
}

std::vector<Key> built(const Topology& topology, OSetKind kind = OSetKind::minimal) {
  OSet set(kind);
  set.build(topology);
  return keys(set, topology.features());
}

/// The definitions, computed literally from a table of adjacency.
std::vector<Key> by_definition(const Topology& topology, OSetKind kind) {
  const Mesh& mesh = topology.mesh();
  const Features& features = topology.features();
  const Index n = mesh.element_slots();
  std::vector<char> table(std::size_t{n} * n, 0);
  const auto adjacent = [&](Index a, Index b) -> char& { return table[std::size_t{a} * n + b]; };
  for (Index a = 0; a < n; ++a)
    for (Index b = 0; b < n; ++b)
      for (Index v : mesh.vertices(a))
        for (Index w : mesh.vertices(b)) adjacent(a, b) |= v == w;

  const auto is_in = [&](std::span<const Index> inc_a, std::span<const Index> inc_b) {
    if (kind == OSetKind::minimal)
      return std::all_of(inc_a.begin(), inc_a.end(), [&](Index oi) {
        return std::all_of(inc_b.begin(), inc_b.end(), [&](Index oj) { return adjacent(oi, oj); });
      });
    for (Index oi : inc_a)
      for (Index oj : inc_b) {
        bool in = adjacent(oi, oj) != 0;
        for (Index ok : inc_a) in &= adjacent(ok, oj) != 0;
        for (Index ol : inc_b) in &= adjacent(oi, ol) != 0;
        if (in) return true;
      }
    return false;
  };
  std::vector<Key> keys;
  for (Index v = 0; v < features.vertex_slots(); ++v)
    for (Index f = 0; f < features.triangle_slots(); ++f)
      if (!features.vertex_elements(v).empty() && is_test(features, FeatureKind::vf, {v, f}) &&
          is_in(features.vertex_elements(v), features.triangle_elements(f)))
        keys.push_back(key(features, FeatureKind::vf, {v, f}));
  for (Index a = 0; a < features.edge_slots(); ++a)
    for (Index b = a + 1; b < features.edge_slots(); ++b)
      if (is_test(features, FeatureKind::ee, {a, b}) && is_in(features.edge_elements(a), features.edge_elements(b)))
        keys.push_back(key(features, FeatureKind::ee, {a, b}));
  std::sort(keys.begin(), keys.end());
  return keys;
}

std::vector<Index> distinct_vertices(Random& random, Index vertices, std::size_t n) {
  std::vector<Index> picked;
  while (picked.size() < n) {
    const auto v = static_cast<Index>(random.below(vertices));
    if (std::find(picked.begin(), picked.end(), v) == picked.end()) picked.push_back(v);
  }
  return picked;
}

/// A prism over an n-gon, as a polytope.
ElementSpec prism(std::vector<Index> v) {
  ElementSpec spec;
  spec.type = ElementType::polytope;
  const auto n = static_cast<Index>(v.size() / 2);
  for (const Index base : {0u, n}) {
    spec.faces.push_back(n);
    for (Index i = 0; i < n; ++i) spec.faces.push_back(v[base + i]);
  }
  for (Index i = 0; i < n; ++i)
    for (Index w : {Index{4}, v[i], v[(i + 1) % n], v[n + (i + 1) % n], v[n + i]}) spec.faces.push_back(w);
  spec.vertices = std::move(v);
  return spec;
}

/// An element on random vertices: of the given type, or a prism with `sides` sides.
ElementSpec random_element(Random& random, Index vertices, ElementType type, std::int64_t id, std::size_t sides = 5) {
  ElementSpec spec;
  if (type == ElementType::polytope) {
    spec = prism(distinct_vertices(random, vertices, 2 * sides));
  } else {
    spec.type = type;
    spec.vertices = distinct_vertices(random, vertices, static_cast<std::size_t>(vertex_count(type)));
  }
  spec.id = id;
  return spec;
}

/// Vertices in clusters. Each element lies in one cluster or between two neighbouring ones, so that not all elements
/// are adjacent.
Mesh soup(Random& random, std::span<const ElementType> types, Index clusters, Index per_cluster, int elements) {
  Mesh mesh;
  mesh.add_vertices(clusters * per_cluster);
  for (int i = 0; i < elements; ++i) {
    const Index span = random.below(3) == 0 && clusters > 1 ? 2 : 1;
    const auto at = static_cast<Index>(random.below(clusters - span + 1));
    ElementSpec spec = random_element(random, span * per_cluster, types[random.below(types.size())], i);
    spec.renumber([&](Index v) { return v + at * per_cluster; });
    mesh.add_element(spec);
  }
  return mesh;
}

TEST(OSet, SoupsByDefinition) {
  Random random(11);
  const std::vector<std::vector<ElementType>> mixes = {
      {ElementType::tetrahedron},
      {ElementType::tetrahedron, ElementType::triangle},
      {ElementType::quad, ElementType::wedge, ElementType::pyramid},
      {ElementType::hexahedron, ElementType::triangle},
      {ElementType::polytope, ElementType::tetrahedron, ElementType::triangle}};
  for (const auto& mix : mixes)
    for (int round = 0; round < 12; ++round) {
      const bool large = mix.front() == ElementType::polytope || mix.front() == ElementType::hexahedron;
      const Mesh mesh = soup(random, mix, 2 + static_cast<Index>(random.below(4)), large ? 12 : 7, 14);
      for (const EdgeSet edges : {EdgeSet::triangulated, EdgeSet::polytope}) {
        const Topology topology(mesh, edges);
        for (const OSetKind kind : {OSetKind::minimal, OSetKind::literal})
          ASSERT_EQ(built(topology, kind), by_definition(topology, kind)) << to_string(mix.front()) << " " << round;
      }
    }
}

/// Elements at a feature are examined 64 at a time. Here a fan of n tetrahedra surrounds an edge, one prism touches all
/// of them, and another one only the first 66. Triangles increase the counts of the later tetrahedra, so that the first
/// ones are examined first.
TEST(OSet, MoreElementsAroundAFeatureThanBits) {
  for (const Index n : {62u, 63u, 64u, 65u, 128u, 129u, 130u}) {
    Mesh mesh;
    mesh.add_vertices(2 + (n + 1) + 2);
    std::int64_t id = 0;
    const auto add = [&](ElementType type, std::vector<Index> vertices) {
      mesh.add_element({type, std::move(vertices), {}, 0, id++});
    };
    const auto add_prism = [&](Index sides) {
      std::vector<Index> vertices(2 * sides);
      std::iota(vertices.begin(), vertices.end(), 2u);
      ElementSpec spec = prism(std::move(vertices));
      spec.id = id++;
      mesh.add_element(spec);
    };
    for (Index i = 0; i < n; ++i) add(ElementType::tetrahedron, {0, 1, 2 + i, 3 + i});
    for (Index i = 60; i < n; ++i) add(ElementType::triangle, {3 + i, n + 3, n + 4});
    add_prism((n + 1) / 2);
    if (n > 66) add_prism(33);
    const Topology topology(std::move(mesh));
    ASSERT_EQ(built(topology), by_definition(topology, OSetKind::minimal)) << n;
  }
}

TEST(OSet, OneAloneAndTwoApart) {
  Mesh mesh;
  mesh.add_vertices(8);
  mesh.add_element({ElementType::tetrahedron, {0, 1, 2, 3}, {}, 0, 0});
  Topology topology(std::move(mesh));
  OSet set;
  set.update(topology);
  EXPECT_EQ(set.counts(), (OSetCounts{4, 3})) << "all that there is inside a tetrahedron";

  TopologyEdit edit;
  edit.added.push_back({ElementType::tetrahedron, {4, 5, 6, 7}, {}, 0, 1});
  topology.apply(edit);
  set.update(topology);
  EXPECT_EQ(set.counts(), (OSetCounts{8, 6})) << "nothing between elements that are not adjacent";

  const Topology other(block(ElementType::hexahedron, 2, 1, 1).mesh());
  set.update(other);
  EXPECT_EQ(keys(set, other.features()), built(other)) << "another topology";

  const Topology empty{Mesh()};
  set.update(empty);
  EXPECT_EQ(set.counts(), OSetCounts{});
}

ElementSpec spec_of(const Mesh& mesh, Index o) {
  const auto vertices = mesh.vertices(o), faces = mesh.polytope_faces(o);
  return {mesh.type(o),
          {vertices.begin(), vertices.end()},
          {faces.begin(), faces.end()},
          mesh.object(o),
          mesh.element_id(o)};
}

/// Random changes that keep the topology similar to that of its generator: elements are removed, added again, or made
/// new on vertices that are near each other, old or new ones.
class Editor {
 public:
  Editor(Topology& topology, std::uint64_t seed, std::vector<ElementType> types)
      : topology_(topology), random_(seed), types_(std::move(types)), next_id_(1'000'000) {}

  Random& random() { return random_; }

  void edit(std::size_t removals, std::size_t returns, std::size_t inventions) {
    const Mesh& mesh = topology_.mesh();
    TopologyEdit edit;
    for (std::size_t i = 0; i < returns && !out_.empty(); ++i) {
      const std::size_t at = random_.below(out_.size());
      edit.added.push_back(out_[at]);
      out_.erase(out_.begin() + static_cast<std::ptrdiff_t>(at));
    }
    std::set<Index> removed;
    for (std::size_t i = 0; i < removals && mesh.element_count() > removed.size() + 8; ++i) {
      const auto o = static_cast<Index>(random_.below(mesh.element_slots()));
      if (mesh.is_live(o) && removed.insert(o).second) out_.push_back(spec_of(mesh, o));
    }
    edit.removed.assign(removed.begin(), removed.end());
    if (random_.below(4) == 0) edit.new_vertex_ids.push_back(mesh.vertex_id(mesh.vertex_count() - 1) + 1);
    for (std::size_t i = 0; i < inventions; ++i) invent(edit);
    topology_.apply(edit);
  }

  /// All elements within a number of adjacency steps from a random one, but at most `most`.
  void remove_region(std::size_t most) {
    const Mesh& mesh = topology_.mesh();
    Index start = 0;
    do start = static_cast<Index>(random_.below(mesh.element_slots()));
    while (!mesh.is_live(start));
    std::vector<Index> region{start};
    std::set<Index> seen{start};
    for (std::size_t i = 0; i < region.size() && region.size() < most; ++i)
      for (Index v : mesh.vertices(region[i]))
        for (Index o : topology_.features().vertex_elements(v))
          if (region.size() < most && seen.insert(o).second) region.push_back(o);
    for (Index o : region) out_.push_back(spec_of(mesh, o));
    TopologyEdit edit;
    edit.removed = region;
    topology_.apply(edit);
  }
  void put_everything_back() {
    TopologyEdit edit;
    edit.added = std::exchange(out_, {});
    topology_.apply(edit);
  }

 private:
  void invent(TopologyEdit& edit) {
    const ElementType type = types_[random_.below(types_.size())];
    const Index vertices = topology_.mesh().vertex_count() + static_cast<Index>(edit.new_vertex_ids.size());
    const std::size_t n = type == ElementType::polytope ? 10 : static_cast<std::size_t>(vertex_count(type));
    const auto window = static_cast<Index>(std::min<std::size_t>(vertices, 2 * n + 2));
    const auto at =
        random_.below(4) == 0 ? vertices - window : static_cast<Index>(random_.below(vertices - window + 1));
    ElementSpec spec = random_element(random_, window, type, next_id_++);
    spec.renumber([&](Index v) { return v + at; });
    edit.added.push_back(std::move(spec));
  }

  Topology& topology_;
  Random random_;
  std::vector<ElementType> types_;
  std::vector<ElementSpec> out_;
  std::int64_t next_id_;
};

/// Compares OSet after elements were added and removed, one by one and together, once or several times between two
/// updates.
void expect_updates_equal_rebuilds(Mesh mesh, std::vector<ElementType> types, std::uint64_t seed, int rounds,
                                   OSetKind kind = OSetKind::minimal, EdgeSet edges = EdgeSet::triangulated) {
  Topology topology(std::move(mesh), edges);
  Editor editor(topology, seed, std::move(types));
  Random& random = editor.random();
  OSet set(kind);
  for (int round = 0; round < rounds; ++round) {
    set.update(topology);
    ASSERT_EQ(keys(set, topology.features()), built(topology, kind)) << "seed " << seed << ", round " << round;
    const std::size_t most = 1 + topology.mesh().element_count() / 24;
    const std::uint64_t edits = random.below(10) == 0 ? Topology::kHistory + 2 : 1 + random.below(3);
    for (std::uint64_t i = 0; i < edits; ++i) switch (random.below(6)) {
        case 0: editor.edit(random.below(most) + 1, 0, 0); break;
        case 1: editor.edit(0, random.below(most) + 1, 0); break;
        case 2: editor.edit(0, 0, random.below(3) + 1); break;
        case 3: editor.remove_region(most); break;
        default: editor.edit(random.below(most), random.below(most), random.below(3)); break;
      }
  }
}

TEST(OSetUpdate, Tetrahedra) {
  const std::vector<ElementType> types = {ElementType::tetrahedron};
  expect_updates_equal_rebuilds(block(ElementType::tetrahedron, 3, 3, 3).mesh(), types, 1, 40);
  expect_updates_equal_rebuilds(block(ElementType::tetrahedron, 1, 1, 30).mesh(), types, 2, 40);
  expect_updates_equal_rebuilds(permuted(block(ElementType::tetrahedron, 2, 2, 10), 3).mesh(), types, 3, 40);
}

TEST(OSetUpdate, TetrahedraAndTriangles) {
  const std::vector<ElementType> types = {ElementType::tetrahedron, ElementType::triangle};
  Shape shape = block(ElementType::tetrahedron, 2, 2, 4);
  shape.append(block(ElementType::triangle, 6, 5, 0), 1);
  expect_updates_equal_rebuilds(shape.mesh(), types, 4, 40);
}

TEST(OSetUpdate, SoupsOfSimplices) {
  const std::vector<ElementType> types = {ElementType::tetrahedron, ElementType::triangle};
  Random random(21);
  for (std::uint64_t seed = 0; seed < 12; ++seed)
    expect_updates_equal_rebuilds(soup(random, types, 8, 6, 70), types, 100 + seed, 30);
}

/// The features have more elements than a word has bits, so that the update processes them in several parts.
TEST(OSetUpdate, ManyElementsAroundAFeature) {
  const std::vector<ElementType> types = {ElementType::tetrahedron, ElementType::triangle};
  Random random(22);
  for (std::uint64_t seed = 0; seed < 3; ++seed)
    expect_updates_equal_rebuilds(soup(random, types, 3, 9, 420), types, 200 + seed, 12);
}

/// Simplices are added and removed between elements in which not all pairs of vertices are edges, and not all triples
/// are triangles.
TEST(OSetUpdate, SimplicesAmongOthers) {
  using enum ElementType;
  const std::vector<ElementType> types = {tetrahedron, tetrahedron, tetrahedron, triangle,
                                          triangle,    triangle,    hexahedron,  quad};
  Random random(23);
  for (std::uint64_t seed = 0; seed < 8; ++seed)
    for (const EdgeSet edges : {EdgeSet::triangulated, EdgeSet::polytope})
      expect_updates_equal_rebuilds(soup(random, types, 5, 9, 50), {tetrahedron, triangle}, 300 + seed, 30,
                                    OSetKind::minimal, edges);
}

TEST(OSetUpdate, OtherElements) {
  expect_updates_equal_rebuilds(block(ElementType::hexahedron, 4, 3, 3).mesh(), {ElementType::hexahedron}, 5, 15);
  expect_updates_equal_rebuilds(
      mixed_block(2, 2).mesh(),
      {ElementType::tetrahedron, ElementType::wedge, ElementType::pyramid, ElementType::quad, ElementType::polytope}, 6,
      25);
}

TEST(OSetUpdate, Literal) {
  expect_updates_equal_rebuilds(block(ElementType::tetrahedron, 2, 2, 3).mesh(), {ElementType::tetrahedron}, 7, 20,
                                OSetKind::literal);
}

/// A hundred small changes and their reversal: invalid entries are removed by compaction, so that memory does not grow.
TEST(OSetUpdate, NothingPilesUp) {
  Topology topology(block(ElementType::tetrahedron, 3, 3, 8).mesh());
  const std::vector<Key> before = built(topology);
  Editor editor(topology, 8, {ElementType::tetrahedron});
  OSet set;
  set.update(topology);
  std::size_t most = 0;
  for (int round = 0; round < 150; ++round) {
    editor.edit(6, 0, 0);
    set.update(topology);
    editor.put_everything_back();
    set.update(topology);
    most = std::max(most, set.blocks());
  }
  EXPECT_EQ(keys(set, topology.features()), before);
  OSet fresh;
  fresh.build(topology);
  EXPECT_LE(most, 3 * fresh.blocks() + 80);
  EXPECT_LE(set.bytes(), 4 * fresh.bytes() + 200'000);
}

TEST(OSetUpdate, DownToNothingAndBack) {
  Topology topology(block(ElementType::tetrahedron, 2, 2, 2).mesh());
  const std::vector<Key> before = built(topology);
  Editor editor(topology, 9, {ElementType::tetrahedron});
  OSet set;
  set.update(topology);
  editor.remove_region(1000);
  ASSERT_EQ(topology.mesh().element_count(), 0u);
  set.update(topology);
  EXPECT_EQ(set.counts(), OSetCounts{});
  editor.put_everything_back();
  set.update(topology);
  EXPECT_EQ(keys(set, topology.features()), before);
}

}  // namespace
}  // namespace volccd
