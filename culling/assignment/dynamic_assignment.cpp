#include <volccd/culling/assignment/dynamic_assignment.hpp>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/culling/assignment/detail/append_tests.hpp>

namespace volccd {

namespace {

/// Features of one element of a pair that can occur in a test that the pair owns.
struct Candidates {
  std::vector<Index> own;    ///< features whose first incident element is this one
  std::vector<Index> later;  ///< features with earlier incident elements, all of which are adjacent to the pair's other
                             ///< element

  void clear() { own.clear(), later.clear(); }
  bool empty() const { return own.empty() && later.empty(); }
  std::size_t bytes() const { return heap_bytes(own, later); }
};

/// Scratch memory of one worker.
struct alignas(64) Scratch {
  Candidates vertices, triangles, edges_a, edges_b;

  std::size_t bytes() const { return heap_bytes(vertices, triangles, edges_a, edges_b); }
};

struct DynamicAssignmentState final : StageState {
  std::vector<Scratch> workers;

  std::size_t bytes() const override { return heap_bytes(workers); }
};

enum class Kind { vertex, triangle, edge };

/// Appends the tests that element pairs own. For a pair (o1, o2), let a be a feature of o1 and b a feature of o2. If
/// (o1, o2) is the first non-adjacent pair in inc(a) x inc(b), or (o2, o1) is the first in inc(b) x inc(a), then all
/// elements of inc(a) before o1 are adjacent to o2, and all elements of inc(b) before o2 are adjacent to o1. Each of
/// these two conditions concerns one feature only (Candidates). They are sufficient for inc(a) x inc(b) if o1 is the
/// first element of inc(a).
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
    Candidates &vertices = scratch_.vertices, &triangles = scratch_.triangles;
    find<Kind::vertex>(o_v, o_f, mask, vertices);
    if (vertices.empty()) return;
    const std::span<const Index> own = features_.own_triangles(o_f);
    detail::append_vf(vertices.own, own, out_.vf);
    if (!connected_) return;
    find<Kind::triangle>(o_f, o_v, std::uint32_t{0}, triangles);
    detail::append_vf(vertices.own, triangles.later, out_.vf);
    for (const Index v : vertices.later)
      for (const auto& list : {own, std::span<const Index>(triangles.later)})
        for (const Index f : list)
          if (covers(o_v, elements<Kind::vertex>(v), o_f, elements<Kind::triangle>(f))) out_.vf.push_back({v, f});
  }

  void append_ee(ElementPair pair, const FeatureMask& mask) {
    if (!connected_ && (mask.edges_a | mask.edges_b) == 0)
      return detail::append_ee(features_.own_edges(pair.a), features_.own_edges(pair.b), out_.ee);
    Candidates &edges_a = scratch_.edges_a, &edges_b = scratch_.edges_b;
    find<Kind::edge>(pair.a, pair.b, mask.edges_a, edges_a);
    if (edges_a.empty()) return;
    find<Kind::edge>(pair.b, pair.a, mask.edges_b, edges_b);
    detail::append_ee(edges_a.own, edges_b.own, out_.ee);
    append_later_ee(pair, edges_a.own, true, edges_b.later, false);
    append_later_ee(pair, edges_a.later, false, edges_b.own, true);
    append_later_ee(pair, edges_a.later, false, edges_b.later, false);
  }

  /// Appends tests of edges not all of which are `own`. An EE pair is considered in the order of its edge slots.
  void append_later_ee(ElementPair pair, std::span<const Index> edges_a, bool own_a, std::span<const Index> edges_b,
                       bool own_b) {
    for (const Index e : edges_a)
      for (const Index g : edges_b)
        if (e < g) {
          if (own_a || covers(pair.a, elements<Kind::edge>(e), pair.b, elements<Kind::edge>(g)))
            out_.ee.push_back({e, g});
        } else if (own_b || covers(pair.b, elements<Kind::edge>(g), pair.a, elements<Kind::edge>(e))) {
          out_.ee.push_back({g, e});
        }
  }

  /// Classifies the features of element o for its pair with `other`.
  template <Kind K, class Mask>
  void find(Index o, Index other, Mask mask, Candidates& found) const {
    found.clear();
    Index apart = kNone;  // features of one element often have the same first element
    detail::for_each_unmasked(features_of<K>(o), mask, [&](Index i) {
      const Index first = first_element<K>(i);
      if (first == o) {
        found.own.push_back(i);
      } else if (connected_ && first != apart) {
        if (!adjacency_.adjacent(first, other))
          apart = first;
        else if (others_adjacent(elements<K>(i), o, other))
          found.later.push_back(i);
      }
    });
  }

  /// Whether all elements of inc after the first one and before o are adjacent to `other`.
  bool others_adjacent(std::span<const Index> inc, Index o, Index other) const {
    for (std::size_t k = 1; inc[k] != o; ++k)
      if (!adjacency_.adjacent(inc[k], other)) return false;
    return true;
  }

  /// Whether all elements of inc_a before o_a are adjacent to all elements of inc_b. Pre: they are adjacent to o_b.
  bool covers(Index o_a, std::span<const Index> inc_a, Index o_b, std::span<const Index> inc_b) const {
    for (std::size_t i = 0; inc_a[i] != o_a; ++i)
      for (const Index q : inc_b)
        if (q != o_b && !adjacency_.adjacent(inc_a[i], q)) return false;
    return true;
  }

  template <Kind K>
  std::span<const Index> features_of(Index o) const {
    if constexpr (K == Kind::vertex) return mesh_.vertices(o);
    if constexpr (K == Kind::triangle) return features_.element_triangles(o);
    if constexpr (K == Kind::edge) return features_.element_edges(o);
  }
  template <Kind K>
  std::span<const Index> elements(Index i) const {
    if constexpr (K == Kind::vertex) return features_.vertex_elements(i);
    if constexpr (K == Kind::triangle) return features_.triangle_elements(i);
    if constexpr (K == Kind::edge) return features_.edge_elements(i);
  }
  template <Kind K>
  Index first_element(Index i) const {
    if constexpr (K == Kind::vertex) return features_.first_element_of_vertex(i);
    if constexpr (K == Kind::triangle) return features_.first_element_of_triangle(i);
    if constexpr (K == Kind::edge) return features_.first_element_of_edge(i);
  }
  const Mesh& mesh_;
  const Features& features_;
  const Adjacency& adjacency_;
  const bool objects_apart_;  ///< whether elements of different objects are never adjacent
  bool connected_ = true;     ///< whether elements of the objects of the current pair may be adjacent
  Scratch& scratch_;
  TestBatch& out_;
};

}  // namespace

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
      "dynamic-assignment",
      "each test by the first non-adjacent element pair that has it (Algorithm 5); needs the O-Set", Guarantee::exact);
}

}  // namespace volccd
