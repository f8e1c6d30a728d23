// The table that assignment looks features up in follows edits, and stays as it was where memory runs out.
#include <optional>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/culling/detail/assignment_table.hpp>
#include <volccd/mesh/shapes.hpp>
#include <volccd/query/pairs.hpp>

#include "support/allocations.hpp"

namespace volccd {
namespace {

/// What the table must tell of the live features and elements of a topology, from definitions.
struct Truth {
  std::vector<std::pair<Index, Index>> vertices, edges, triangles;  ///< slot, first element
  std::vector<std::pair<ElementPair, bool>> adjacent;

  explicit Truth(const Topology& topology) {
    const Mesh& mesh = topology.mesh();
    const Features& features = topology.features();
    const auto first = [&](std::span<const Index> feature) {
      for (Index o = 0; o < mesh.element_slots(); ++o) {
        const auto v = mesh.vertices(o);
        if (std::all_of(feature.begin(), feature.end(),
                        [&](Index i) { return std::find(v.begin(), v.end(), i) != v.end(); }))
          return o;
      }
      return kNone;
    };
    for (Index v = 0; v < features.vertex_slots(); ++v)
      if (!features.vertex_elements(v).empty()) vertices.emplace_back(v, first(std::span(&v, 1)));
    for (Index e = 0; e < features.edge_slots(); ++e)
      if (!features.edge_elements(e).empty()) edges.emplace_back(e, first(features.edge(e)));
    for (Index f = 0; f < features.triangle_slots(); ++f)
      if (!features.triangle_elements(f).empty()) triangles.emplace_back(f, first(features.triangle(f)));
    for (Index a = 0; a < mesh.element_slots(); ++a)
      for (Index b = a; b < mesh.element_slots(); ++b) {
        const auto v = mesh.vertices(a), w = mesh.vertices(b);
        if (mesh.alive(a) && mesh.alive(b))
          adjacent.push_back({{a, b}, std::find_first_of(v.begin(), v.end(), w.begin(), w.end()) != v.end()});
      }
  }

  bool told_by(const detail::AssignmentTable& table) const {
    bool right = true;
    for (const auto& [v, o] : vertices) right = right && table.of_vertex(v) == o;
    for (const auto& [e, o] : edges) right = right && table.of_edge(e) == o;
    for (const auto& [f, o] : triangles) right = right && table.of_triangle(f) == o;
    for (const auto& [pair, expected] : adjacent) right = right && table.adjacent(pair.a, pair.b) == expected;
    return right;
  }
};

TEST(AssignmentTable, FollowsEditsAsAWholeOrNotAtAll) {
  // Tetrahedra: every element that has a feature's vertices has the feature.
  const Shape shape = permuted(block(ElementType::tetrahedron, 3, 2, 2), 4),
              other = block(ElementType::tetrahedron, 2, 1, 1);
  Topology topology(shape.mesh());
  const Topology foreign(other.mesh());
  detail::AssignmentTable table;
  Random random(8);
  std::vector<ElementSpec> out;
  std::optional<Truth> before;
  std::size_t failures = 0;
  std::int64_t next_id = 1000;
  for (int step = 0; step < 24; ++step) {
    // Now and then the table is shown another topology in between, or misses more edits than the history holds.
    const Topology& shown = step % 8 == 5 ? foreign : topology;
    failures += test::fail_allocations(
        step % 2 == 0 ? test::Memory::lacks_once : test::Memory::stays_out, [&] { table.update(shown); },
        [&] { ASSERT_TRUE(!before || before->told_by(table)) << "step " << step; });
    before.emplace(shown);
    ASSERT_TRUE(before->told_by(table)) << "step " << step;
    for (std::size_t k = 0; k < (step % 8 == 3 ? Topology::kHistory + 1 : 1); ++k) {
      TopologyEdit edit;
      edit.added = std::move(out);
      out.clear();
      for (ElementSpec& element : edit.added) element.id = next_id++;
      for (Index o = 0; o < topology.mesh().element_slots(); ++o)
        if (topology.mesh().alive(o) && random.below(4) == 0) {
          edit.removed.push_back(o);
          const auto v = topology.mesh().vertices(o);
          out.push_back({ElementType::tetrahedron, {v.begin(), v.end()}, {}, 0, 0});
        }
      // New vertices and elements, so that the arrays grow.
      const Index n = topology.mesh().vertex_count();
      edit.new_vertex_ids = {topology.mesh().vertex_ids().back() + 1};
      edit.added.push_back({ElementType::tetrahedron, {n, n - 1, n - 2, n - 3}, {}, 0, next_id++});
      topology.apply(edit);
    }
  }
  EXPECT_GT(failures, 15u);
}

}  // namespace
}  // namespace volccd
