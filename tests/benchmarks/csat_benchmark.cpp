// Nanoseconds of CSAT for an element pair: by axis and mode, on a block of tetrahedra, triangles or hexahedra that
// twists; by batch size; and on two blocks inside each other (`crossing`), where many pairs overlap.
#include <algorithm>
#include <cmath>
#include <string>

#include <benchmark/benchmark.h>

#include <Eigen/Geometry>

#include <volccd/culling/csat/csat.hpp>
#include <volccd/oracle/cases/shapes.hpp>

namespace volccd {
namespace {

/// Non-adjacent pairs whose swept boxes overlap.
struct Scene {
  Scene(ElementType type, bool crossing) : Scene(crossing ? crossing_blocks(type) : jittered_block(type)) {}
  explicit Scene(const Shape& shape) : topology(shape.mesh()), motion(twisted(shape.positions)) {
    const Mesh& mesh = topology.mesh();
    std::vector<Eigen::AlignedBox<double, 3>> boxes(mesh.element_slots());
    for (Index o = 0; o < mesh.element_slots(); ++o)
      for (const Index v : mesh.vertices(o)) boxes[o].extend(motion.point(v, 0)).extend(motion.point(v, 1));
    for (Index a = 0; a < mesh.element_slots(); ++a)
      for (Index b = a + 1; b < mesh.element_slots(); ++b)
        if (boxes[a].intersects(boxes[b]) && !topology.adjacency().adjacent(a, b)) pairs.push_back({a, b});
  }

  static Shape jittered_block(ElementType type) {
    Shape shape = block(type, 6, 6, 12);
    if (type == ElementType::triangle)
      for (int layer = 1; layer < 24; ++layer) shape.append(block(type, 6, 6, 1).translate(Vec3(0, 0, 0.5 * layer)), 0);
    shape.positions = jittered(shape.positions, 0.2, 1);
    return shape;
  }
  static Shape crossing_blocks(ElementType type) {
    Shape shape = block(type, 4, 4, 6);
    shape.append(block(type, 4, 4, 6).translate(Vec3(0.3, 0.4, 0.5)), 1);
    shape.positions = jittered(shape.positions, 0.2, 1);
    return shape;
  }
  static Motion twisted(const std::vector<Vec3>& x0) {
    std::vector<Vec3> x1 = x0;
    for (Vec3& p : x1) {
      const double angle = 0.1 * (p[2] - 6), c = std::cos(angle), s = std::sin(angle);
      p = Vec3(3 + c * (p[0] - 3) - s * (p[1] - 3), 3 + s * (p[0] - 3) + c * (p[1] - 3), 0.95 * p[2]);
    }
    return Motion::linear(x0, x1);
  }

  Topology topology;
  Motion motion;
  ObjectFilter filter;
  std::vector<ElementPair> pairs;
};

const Scene& scene(ElementType type, bool crossing) {
  static const Scene tetrahedra(ElementType::tetrahedron, false), hexahedra(ElementType::hexahedron, false),
      triangles(ElementType::triangle, false), overlapping(ElementType::tetrahedron, true);
  if (crossing) return overlapping;
  return type == ElementType::tetrahedron ? tetrahedra : type == ElementType::hexahedron ? hexahedra : triangles;
}

void run(benchmark::State& state, const OptionValues& options, ElementType type, bool crossing, std::size_t max) {
  const auto stage = describe_csat().make(options);
  const Scene& s = scene(type, crossing);
  PairBatch batch;
  StageState none;
  std::size_t kept = 0, rounds = 0;
  for (auto _ : state) {
    for (std::size_t i = 0; i < s.pairs.size(); i += max) {
      batch.assign(std::span(s.pairs).subspan(i, std::min(max, s.pairs.size() - i)));
      stage->run({s.topology, s.motion, s.filter}, none, 0, batch);
      kept += batch.size();
    }
    ++rounds;
  }
  const auto done = static_cast<double>(rounds * s.pairs.size());
  state.counters["per_pair"] = benchmark::Counter(done, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["kept"] = static_cast<double>(kept) / done;
  state.counters["pairs"] = static_cast<double>(s.pairs.size());
}

[[maybe_unused]] const bool registered = [] {
  for (const auto type : {ElementType::tetrahedron, ElementType::hexahedron, ElementType::triangle})
    for (const char* mode : {"pair", "features", "both"})
      for (const char* axis : {"face", "predetermined", "velocity", "centroid", "optimal"}) {
        const OptionValues options = {{"axis", axis}, {"mode", mode}};
        const std::string name = std::string("csat/") + to_string(type) + "/" + mode + "/" + axis;
        benchmark::RegisterBenchmark(name.c_str(), run, options, type, false, 1024);
      }
  const OptionValues optimal = {{"axis", "optimal"}, {"mode", "pair"}};
  benchmark::RegisterBenchmark("csat/crossing/pair/optimal", run, optimal, ElementType::tetrahedron, true, 256);
  for (const std::size_t max : {1, 4, 16, 64, 256})
    benchmark::RegisterBenchmark(("csat/batches/" + std::to_string(max)).c_str(), run, optimal,
                                 ElementType::tetrahedron, false, max);
  return true;
}();

}  // namespace
}  // namespace volccd
