#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/query/object_filter.hpp>

#include "mesh/naive_features.hpp"

namespace volccd {
namespace {

using Rule = bool (*)(std::int32_t, std::int32_t);

struct Case {
  ObjectFilter filter;
  Rule allows;
};

std::vector<Case> cases() {
  ObjectFilter excluding, both(PairScope::inter);
  excluding.exclude(2, 1);
  excluding.exclude(0, 0);
  both.exclude(0, 2);
  return {{ObjectFilter(), [](std::int32_t, std::int32_t) { return true; }},
          {ObjectFilter(PairScope::inter), [](std::int32_t a, std::int32_t b) { return a != b; }},
          {ObjectFilter(PairScope::intra), [](std::int32_t a, std::int32_t b) { return a == b; }},
          {excluding, [](std::int32_t a, std::int32_t b) { return !(a * b == 2 && a != b) && !(a == 0 && b == 0); }},
          {both, [](std::int32_t a, std::int32_t b) { return a != b && !(a + b == 2 && a != 1); }}};
}

/// A block whose elements are distributed at random over three objects, so that features belong to one, two or three
/// objects, or are all in one object; and a second block.
Shape dealt(std::uint64_t seed, bool shared) {
  Shape shape = mixed_block(1, 1);
  Random random(seed);
  for (ElementSpec& element : shape.elements) element.object = shared ? static_cast<std::int32_t>(random.below(3)) : 0;
  Shape other = block(ElementType::tetrahedron, 2, 1, 1);
  shape.append(other.translate({0, 0, 3}), 2);
  return shape;
}

/// Whether the objects of some element of one set and of some element of the other set are allowed.
bool some_allowed(const Mesh& mesh, const test::Elements& a, const test::Elements& b, Rule allows) {
  for (const Index i : a)
    for (const Index j : b)
      if (allows(mesh.object(i), mesh.object(j))) return true;
  return false;
}

TEST(ObjectFilter, AsksForTheFeaturePairsOfItsDefinition) {
  for (const bool shared : {true, false})
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
      const Topology topology(dealt(seed, shared).mesh());
      ASSERT_EQ(topology.objects_share_vertices(), shared);
      const Mesh& mesh = topology.mesh();
      const Features& features = topology.features();
      const test::NaiveFeatures naive = test::naive_features(mesh, features.edge_set());
      for (const Case& c : cases()) {
        std::size_t asked = 0, wrong = 0;
        for (const auto& [v, at_v] : naive.vertices)
          for (const auto& [t, at_t] : naive.triangles) {
            const bool expected = some_allowed(mesh, at_v, at_t, c.allows);
            asked += expected ? 1 : 0;
            const FeaturePair pair{v, features.find_triangle(t[0], t[1], t[2])};
            wrong += c.filter.asks_for(topology, FeatureKind::vf, pair) != expected ? 1 : 0;
          }
        for (const auto& [e, at_e] : naive.edges)
          for (const auto& [g, at_g] : naive.edges) {
            const bool expected = some_allowed(mesh, at_e, at_g, c.allows);
            asked += expected ? 1 : 0;
            const FeaturePair pair{features.find_edge(e[0], e[1]), features.find_edge(g[0], g[1])};
            wrong += c.filter.asks_for(topology, FeatureKind::ee, pair) != expected ? 1 : 0;
          }
        EXPECT_EQ(wrong, 0u);
        EXPECT_TRUE(asked > 0 || !shared);
      }
    }
}

// The pair is dropped if it is not allowed, and no vertex of its two elements belongs to another object, too.
TEST(ObjectFilter, DropsTheElementPairsOfItsDefinition) {
  for (const bool shared : {true, false})
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
      const Topology topology(dealt(seed, shared).mesh());
      const Mesh& mesh = topology.mesh();
      const test::NaiveFeatures naive = test::naive_features(mesh, EdgeSet::triangulated);
      std::vector<char> pure(mesh.element_slots(), 1);
      for (const auto& [v, elements] : naive.vertices)
        for (const Index o : elements)
          for (const Index other : elements)
            if (mesh.object(other) != mesh.object(o)) pure[o] = 0;
      for (const Case& c : cases()) {
        std::size_t mixed = 0;
        for (Index a = 0; a < mesh.element_slots(); ++a)
          for (Index b = a; b < mesh.element_slots(); ++b) {
            const bool forbidden = !c.allows(mesh.object(a), mesh.object(b));
            mixed += forbidden && pure[a] != pure[b] ? 1 : 0;
            EXPECT_EQ(c.filter.drops(topology, {a, b}), forbidden && pure[a] && pure[b]) << a << ", " << b;
          }
        EXPECT_TRUE(!shared || c.filter.trivial() || mixed > 0);
      }
    }
}

}  // namespace
}  // namespace volccd
