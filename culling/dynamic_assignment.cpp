#include <volccd/culling/dynamic_assignment.hpp>

#include <volccd/culling/detail/masked_features.hpp>

namespace volccd {

namespace {

/// Whether (o1, o2), not adjacent, is the first non-adjacent pair in inc_a x inc_b; o1 is in inc_a and o2 in inc_b, and
/// (inc_a[0], inc_b[0]) is another pair and adjacent.
bool is_first(const Adjacency& adjacency, std::span<const Index> inc_a, std::span<const Index> inc_b, Index o1, Index o2) {
  for (const Index oi : inc_a)
    for (const Index oj : inc_b) {
      if (oi == o1 && oj == o2) return true;
      if (!adjacency.adjacent(oi, oj)) return false;
    }
  return false;  // not reached: (o1, o2) is among them
}

class Owner {
 public:
  explicit Owner(const Topology& topology) : features_(topology.features()), adjacency_(topology.adjacency()) {}

  bool of_vf(Index v, Index f, Index o_v, Index o_f) const {
    const Index first_v = features_.first_element_of_vertex(v), first_f = features_.first_element_of_triangle(f);
    if (first_v == o_v && first_f == o_f) return true;
    if (!adjacency_.adjacent(first_v, first_f)) return false;
    return is_first(adjacency_, features_.vertex_elements(v), features_.triangle_elements(f), o_v, o_f);
  }

  /// e < g.
  bool of_ee(Index e, Index g, Index o_e, Index o_g) const {
    const Index first_e = features_.first_element_of_edge(e), first_g = features_.first_element_of_edge(g);
    if (first_e == o_e && first_g == o_g) return true;
    if (!adjacency_.adjacent(first_e, first_g)) return false;
    return is_first(adjacency_, features_.edge_elements(e), features_.edge_elements(g), o_e, o_g);
  }

 private:
  const Features& features_;
  const Adjacency& adjacency_;
};

void vertex_tests(const Step& step, const Owner& owner, Index o1, Index o2, std::uint32_t mask, TestBatch& out) {
  detail::for_each_unmasked(step.mesh().vertices(o1), mask, [&](Index v) {
    for (const Index f : step.features().element_triangles(o2))
      if (owner.of_vf(v, f, o1, o2)) out.vf.push_back({v, f});
  });
}

void edge_tests(const Step& step, const Owner& owner, ElementPair pair, const FeatureMask& mask, TestBatch& out) {
  const Features& features = step.features();
  detail::for_each_unmasked(features.element_edges(pair.a), mask.edges_a, [&](Index e) {
    detail::for_each_unmasked(features.element_edges(pair.b), mask.edges_b, [&](Index g) {
      if (e < g) {
        if (owner.of_ee(e, g, pair.a, pair.b)) out.ee.push_back({e, g});
      } else if (owner.of_ee(g, e, pair.b, pair.a)) {
        out.ee.push_back({g, e});
      }
    });
  });
}

}  // namespace

const Options<DynamicAssignment::Config>& DynamicAssignment::options() {
  static const Options<Config> options;
  return options;
}

std::string DynamicAssignment::incomplete_on_every() const {
  return "a feature pair all of whose elements are adjacent has no owner, and without an O-Set nobody tests it; use "
         "orphans=o-set";
}

void DynamicAssignment::run(const Step& step, StageState&, unsigned, const PairBatch& batch, TestBatch& out) const {
  const Owner owner(step.topology);
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const ElementPair pair = batch.pairs[i];
    if (step.topology.adjacency().adjacent(pair.a, pair.b)) continue;
    vertex_tests(step, owner, pair.a, pair.b, batch.masks[i].vertices_a, out);
    vertex_tests(step, owner, pair.b, pair.a, batch.masks[i].vertices_b, out);
    edge_tests(step, owner, pair, batch.masks[i], out);
  }
}

StageDescriptor<Assignment> describe_dynamic_assignment() {
  return describe_stage<Assignment, DynamicAssignment>(
      "dynamic-assignment", "each test by the first non-adjacent element pair that has it (Algorithm 5); needs the O-Set",
      Guarantee::exact);
}

}  // namespace volccd
