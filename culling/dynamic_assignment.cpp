#include <volccd/culling/dynamic_assignment.hpp>

#include <volccd/culling/detail/append_tests.hpp>
#include <volccd/culling/detail/masked_features.hpp>

namespace volccd {

namespace {

/// Features of one element of a pair that can be in a test that the pair owns.
struct Candidates {
  std::vector<Index> own;    ///< no other element comes before it
  std::vector<Index> later;  ///< other elements come before it, all of them adjacent to the pair's other element

  void clear() { own.clear(), later.clear(); }
  bool empty() const { return own.empty() && later.empty(); }
  std::size_t bytes() const { return (own.capacity() + later.capacity()) * sizeof(Index); }
};

struct alignas(64) Scratch {
  Candidates vertices, triangles, edges_a, edges_b;
};

struct DynamicAssignmentState final : StageState {
  std::vector<Scratch> workers;

  std::size_t bytes() const override {
    std::size_t sum = workers.capacity() * sizeof(Scratch);
    for (const Scratch& s : workers)
      sum += s.vertices.bytes() + s.triangles.bytes() + s.edges_a.bytes() + s.edges_b.bytes();
    return sum;
  }
};

/// Writes the tests that element pairs own. In a pair (o1, o2) let a be a feature of o1 and b one of o2. That (o1, o2) is
/// the first non-adjacent pair in inc(a) x inc(b), or (o2, o1) in inc(b) x inc(a), requires in both cases that all
/// elements of inc(a) before o1 are adjacent to o2, and all of inc(b) before o2 to o1: two conditions that each concern
/// one feature alone (Candidates). If o1 is the first element of a, these suffice for inc(a) x inc(b).
class OwnedTests {
 public:
  OwnedTests(const Topology& topology, Scratch& scratch, TestBatch& out)
      : mesh_(topology.mesh()),
        features_(topology.features()),
        adjacency_(topology.adjacency()),
        objects_apart_(!topology.objects_share_vertices()),
        scratch_(scratch),
        out_(out) {}

  void append(ElementPair pair, const FeatureMask& mask) {
    connected_ = !objects_apart_ || mesh_.object(pair.a) == mesh_.object(pair.b);
    if (connected_ && adjacency_.adjacent(pair.a, pair.b)) return;
    append_vf(pair.a, pair.b, mask.vertices_a);
    append_vf(pair.b, pair.a, mask.vertices_b);
    append_ee(pair, mask);
  }

 private:
  void append_vf(Index o_v, Index o_f, std::uint32_t mask) {
    const auto of_vertex = [this](Index v) { return features_.vertex_elements(v); };
    const auto of_triangle = [this](Index f) { return features_.triangle_elements(f); };
    Candidates& vertices = scratch_.vertices;
    find(mesh_.vertices(o_v), mask, o_v, o_f, [this](Index v) { return features_.first_element_of_vertex(v); }, of_vertex,
         vertices);
    if (vertices.empty()) return;
    const std::span<const Index> own = features_.own_triangles(o_f);
    detail::append_vf(vertices.own, own, out_.vf);
    if (!connected_) return;
    Candidates& triangles = scratch_.triangles;
    find(features_.element_triangles(o_f), std::uint32_t{0}, o_f, o_v,
         [this](Index f) { return features_.first_element_of_triangle(f); }, of_triangle, triangles);
    detail::append_vf(vertices.own, triangles.later, out_.vf);
    for (const Index v : vertices.later)
      for (const auto& list : {own, std::span<const Index>(triangles.later)})
        for (const Index f : list)
          if (all_adjacent_before(o_v, of_vertex(v), of_triangle(f))) out_.vf.push_back({v, f});
  }

  void append_ee(ElementPair pair, const FeatureMask& mask) {
    const auto first = [this](Index e) { return features_.first_element_of_edge(e); };
    const auto elements = [this](Index e) { return features_.edge_elements(e); };
    Candidates &edges_a = scratch_.edges_a, &edges_b = scratch_.edges_b;
    find(features_.element_edges(pair.a), mask.edges_a, pair.a, pair.b, first, elements, edges_a);
    if (edges_a.empty()) return;
    find(features_.element_edges(pair.b), mask.edges_b, pair.b, pair.a, first, elements, edges_b);
    detail::append_ee(edges_a.own, edges_b.own, out_.ee);
    append_later_ee(edges_a.own, edges_b.later, pair);
    append_later_ee(edges_a.later, edges_b.own, pair);
    append_later_ee(edges_a.later, edges_b.later, pair);
  }

  /// An EE pair is read in the order of its slots.
  void append_later_ee(std::span<const Index> edges_a, std::span<const Index> edges_b, ElementPair pair) {
    for (const Index e : edges_a)
      for (const Index g : edges_b) {
        const std::span<const Index> of_e = features_.edge_elements(e), of_g = features_.edge_elements(g);
        if (e < g ? all_adjacent_before(pair.a, of_e, of_g) : all_adjacent_before(pair.b, of_g, of_e))
          out_.ee.push_back({std::min(e, g), std::max(e, g)});
      }
  }

  /// Sorts out the features of element o, of the pair of o with `other`. Those of one element mostly have few different
  /// first elements, so that the last one that was not adjacent to `other` is remembered.
  template <class Mask, class First, class Elements>
  void find(std::span<const Index> features, Mask mask, Index o, Index other, First&& first, Elements&& elements,
            Candidates& found) const {
    found.clear();
    Index apart = kNone;
    detail::for_each_unmasked(features, mask, [&](Index i) {
      const Index first_o = first(i);
      if (first_o == o) {
        found.own.push_back(i);
      } else if (connected_ && first_o != apart) {
        if (!adjacency_.adjacent(first_o, other))
          apart = first_o;
        else if (adjacent_before(o, elements(i), other))
          found.later.push_back(i);
      }
    });
  }

  /// Whether all elements of inc before o, which is one of them, are adjacent to `other`.
  bool adjacent_before(Index o, std::span<const Index> inc, Index other) const {
    for (const Index p : inc) {
      if (p == o) return true;
      if (!adjacency_.adjacent(p, other)) return false;
    }
    return false;  // not reached
  }

  /// Whether all elements of inc_a before o, which is one of them, are adjacent to all of inc_b.
  bool all_adjacent_before(Index o, std::span<const Index> inc_a, std::span<const Index> inc_b) const {
    for (const Index p : inc_a) {
      if (p == o) return true;
      for (const Index q : inc_b)
        if (!adjacency_.adjacent(p, q)) return false;
    }
    return false;  // not reached
  }

  const Mesh& mesh_;
  const Features& features_;
  const Adjacency& adjacency_;
  const bool objects_apart_;  ///< elements of different objects are never adjacent
  bool connected_ = true;     ///< elements of both objects of the present pair may be adjacent
  Scratch& scratch_;
  TestBatch& out_;
};

}  // namespace

const Options<DynamicAssignment::Config>& DynamicAssignment::options() {
  static const Options<Config> options;
  return options;
}

std::string DynamicAssignment::incomplete_on_every() const {
  return "a feature pair all of whose elements are adjacent has no owner, and without an O-Set nobody tests it; use "
         "orphans=o-set";
}

std::unique_ptr<StageState> DynamicAssignment::make_state() const { return std::make_unique<DynamicAssignmentState>(); }

void DynamicAssignment::prepare(const Step&, StageState& state, Executor& executor) const {
  std::vector<Scratch>& workers = static_cast<DynamicAssignmentState&>(state).workers;
  if (workers.size() < executor.workers()) workers.resize(executor.workers());
}

void DynamicAssignment::run(const Step& step, StageState& state, unsigned worker, const PairBatch& batch,
                            TestBatch& out) const {
  OwnedTests tests(step.topology, static_cast<DynamicAssignmentState&>(state).workers[worker], out);
  for (std::size_t i = 0; i < batch.size(); ++i) tests.append(batch.pairs[i], batch.masks[i]);
}

StageDescriptor<Assignment> describe_dynamic_assignment() {
  return describe_stage<Assignment, DynamicAssignment>(
      "dynamic-assignment", "each test by the first non-adjacent element pair that has it (Algorithm 5); needs the O-Set",
      Guarantee::exact);
}

}  // namespace volccd
