// Nanoseconds of each narrow phase for a test, on feature pairs of a deforming block of hexahedra.
//   near      swept boxes overlap: the tests that a feature filter keeps
//   element   all feature pairs of element pairs whose swept boxes overlap: the tests of NavCCD
//   far       pairs drawn at random
// The counters `contacts`, `degenerate` and `undecided` are shares of the tests.
#include <algorithm>
#include <memory>
#include <type_traits>

#include <benchmark/benchmark.h>

#include <volccd/core/random.hpp>
#include <volccd/narrowphase/cubic/cubic.hpp>
#include <volccd/narrowphase/detail/coplanarity_block.hpp>
#include <volccd/narrowphase/exact/exact.hpp>
#include <volccd/narrowphase/inclusion/inclusion.hpp>
#include <volccd/oracle/cases/shapes.hpp>

#include "support/stages.hpp"

namespace {

using namespace volccd;

constexpr std::size_t kTests = 1 << 17;

enum class Pairs { near, element, far };

struct Box {
  Vec3 low = Vec3::Constant(1e300), high = Vec3::Constant(-1e300);

  void add(const Vec3& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  bool overlaps(const Box& other) const {
    return (low.array() <= other.high.array()).all() && (other.low.array() <= high.array()).all();
  }
};

/// A block with random offsets. Every vertex moves by up to 0.6 of an edge in each direction.
class Scene {
 public:
  static const Scene& get() {
    static const Scene scene;
    return scene;
  }

  Step step() const { return {*topology_, motion_, filter_}; }

  std::vector<FeaturePair> pairs(FeatureKind kind, Pairs wanted) const {
    std::vector<FeaturePair> out;
    Random random(7);
    const Features& f = topology_->features();
    if (wanted == Pairs::element) {
      element_pairs(kind, out);
      random.shuffle(out);
      out.resize(std::min(out.size(), kTests));
    }
    const auto a_slots = kind == FeatureKind::vf ? f.vertex_slots() : f.edge_slots();
    const auto b_slots = kind == FeatureKind::vf ? f.triangle_slots() : f.edge_slots();
    while (out.size() < kTests) {
      const FeaturePair pair{static_cast<Index>(random.below(a_slots)), static_cast<Index>(random.below(b_slots))};
      if (!is_test(f, kind, pair)) continue;
      const std::array<Index, 4> v = test_vertices(f, kind, pair);
      const std::size_t split = kind == FeatureKind::vf ? 1 : 2;
      if (wanted == Pairs::far || box({v.data(), split}).overlaps(box({v.data() + split, 4 - split})))
        out.push_back(pair);
    }
    // In the order of a traversal, so that neighbouring tests are next to each other.
    std::sort(out.begin(), out.end());
    return out;
  }

 private:
  Scene() {
    Shape shape = block(ElementType::hexahedron, 9, 9, 9);
    const std::vector<Vec3> x0 = jittered(shape.positions, 0.2, 1), x1 = jittered(x0, 0.6, 2);
    topology_ = std::make_unique<Topology>(shape.mesh());
    motion_ = Motion::linear(x0, x1);
  }

  Box box(std::span<const Index> vertices) const {
    Box result;
    for (const Index v : vertices) {
      result.add(motion_.point(v, 0));
      result.add(motion_.point(v, 1));
    }
    return result;
  }

  void element_pairs(FeatureKind kind, std::vector<FeaturePair>& out) const {
    const Mesh& mesh = topology_->mesh();
    const Features& f = topology_->features();
    Random random(3);
    while (out.size() < kTests) {
      const Index a = static_cast<Index>(random.below(mesh.element_slots()));
      const Index b = static_cast<Index>(random.below(mesh.element_slots()));
      if (a == b || !box(mesh.vertices(a)).overlaps(box(mesh.vertices(b)))) continue;
      const std::span<const Index> first = kind == FeatureKind::vf ? mesh.vertices(a) : f.element_edges(a);
      const std::span<const Index> second = kind == FeatureKind::vf ? f.element_triangles(b) : f.element_edges(b);
      for (const Index x : first)
        for (const Index y : second)
          if (is_test(f, kind, {x, y})) out.push_back({x, y});
    }
  }

  std::unique_ptr<Topology> topology_;
  Motion motion_;
  ObjectFilter filter_;
};

template <class Narrow>
void tests(benchmark::State& state, FeatureKind kind, Pairs wanted) {
  std::vector<FeaturePair> pairs = Scene::get().pairs(kind, wanted);
  // exact arithmetic takes a thousand times as long
  if (std::is_same_v<Narrow, Exact>) pairs.resize(pairs.size() / 64);
  const Narrow narrow{};
  std::vector<Contact> contacts;
  NarrowCounters counters;
  for (auto _ : state) {
    contacts.clear();
    counters = {};
    test::run_stage(narrow, Scene::get().step(), kind, pairs, contacts, counters);
    benchmark::DoNotOptimize(contacts.data());
  }
  const double n = static_cast<double>(pairs.size());
  state.counters["s/test"] =
      benchmark::Counter(n, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["contacts"] = static_cast<double>(contacts.size()) / n;
  state.counters["degenerate"] = static_cast<double>(counters.degenerate) / n;
  state.counters["undecided"] = static_cast<double>(counters.undecided) / n;
}

/// Times only the vectorised part.
void first_pass(benchmark::State& state, FeatureKind kind, Pairs wanted, bool gather_only) {
  const std::vector<FeaturePair> pairs = Scene::get().pairs(kind, wanted);
  TestBlock tests;
  detail::CoplanarityBlock block;
  std::size_t open = 0;
  for (auto _ : state) {
    open = 0;
    for (std::size_t i = 0; i < pairs.size(); i += detail::CoplanarityBlock::kCapacity) {
      const std::size_t n = std::min(detail::CoplanarityBlock::kCapacity, pairs.size() - i);
      tests.gather(Scene::get().step(), kind, std::span(pairs).subspan(i, n));
      benchmark::ClobberMemory();
      if (gather_only) continue;
      block.compute(tests, true);
      for (std::size_t j = 0; j < n; ++j) open += block.open(j) ? 1 : 0;
    }
    benchmark::DoNotOptimize(open);
  }
  const double n = static_cast<double>(pairs.size());
  state.counters["s/test"] =
      benchmark::Counter(n, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["open"] = static_cast<double>(open) / n;
}

void cubic(benchmark::State& state, FeatureKind kind, Pairs wanted) { tests<Cubic>(state, kind, wanted); }
void inclusion(benchmark::State& state, FeatureKind kind, Pairs wanted) { tests<Inclusion>(state, kind, wanted); }
void exact(benchmark::State& state, FeatureKind kind, Pairs wanted) { tests<Exact>(state, kind, wanted); }

BENCHMARK_CAPTURE(cubic, vf_near, FeatureKind::vf, Pairs::near);
BENCHMARK_CAPTURE(inclusion, vf_near, FeatureKind::vf, Pairs::near);
BENCHMARK_CAPTURE(exact, vf_near, FeatureKind::vf, Pairs::near);
BENCHMARK_CAPTURE(cubic, vf_element, FeatureKind::vf, Pairs::element);
BENCHMARK_CAPTURE(inclusion, vf_element, FeatureKind::vf, Pairs::element);
BENCHMARK_CAPTURE(cubic, vf_far, FeatureKind::vf, Pairs::far);
BENCHMARK_CAPTURE(cubic, ee_near, FeatureKind::ee, Pairs::near);
BENCHMARK_CAPTURE(inclusion, ee_near, FeatureKind::ee, Pairs::near);
BENCHMARK_CAPTURE(exact, ee_near, FeatureKind::ee, Pairs::near);
BENCHMARK_CAPTURE(cubic, ee_element, FeatureKind::ee, Pairs::element);
BENCHMARK_CAPTURE(inclusion, ee_element, FeatureKind::ee, Pairs::element);
BENCHMARK_CAPTURE(cubic, ee_far, FeatureKind::ee, Pairs::far);
BENCHMARK_CAPTURE(first_pass, vf_near_gather, FeatureKind::vf, Pairs::near, true);
BENCHMARK_CAPTURE(first_pass, vf_near, FeatureKind::vf, Pairs::near, false);
BENCHMARK_CAPTURE(first_pass, ee_near_gather, FeatureKind::ee, Pairs::near, true);
BENCHMARK_CAPTURE(first_pass, ee_near, FeatureKind::ee, Pairs::near, false);
BENCHMARK_CAPTURE(first_pass, ee_element, FeatureKind::ee, Pairs::element, false);

}  // namespace

BENCHMARK_MAIN();
