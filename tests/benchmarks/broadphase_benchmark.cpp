// Broad phases on a hundred thousand twisted tetrahedra: octopus2-105k if the shared data is present, else a block.
//
// Each part of a broad phase is timed separately: `update` (a refit for kdop-bvh) and `query`, on one thread. Counters:
// pairs of a query, and pairs in a second.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include <volccd/broadphase/brute_force.hpp>
#include <volccd/broadphase/candidate_pairs.hpp>
#include <volccd/broadphase/kdop_bvh.hpp>
#include <volccd/broadphase/spatial_hash.hpp>
#include <volccd/io/sequence/cells.hpp>
#include <volccd/io/sequence/reader.hpp>
#include <volccd/oracle/cases/shapes.hpp>

namespace volccd {
namespace {

/// Twisted by 10 degrees over its length and shortened by 5 %, along its longest axis.
std::vector<Vec3> twisted(const std::vector<Vec3>& x) {
  Vec3 low = x[0], high = x[0];
  for (const Vec3& p : x) low = low.cwiseMin(p), high = high.cwiseMax(p);
  int axis = 0;
  const double length = (high - low).maxCoeff(&axis);
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const Vec3 centre = (low + high) / 2;
  std::vector<Vec3> y = x;
  for (Vec3& p : y) {
    const double angle = 10 * M_PI / 180 * (p[axis] - low[axis]) / length;
    const double a = p[u] - centre[u], b = p[v] - centre[v];
    p[u] = centre[u] + std::cos(angle) * a - std::sin(angle) * b;
    p[v] = centre[v] + std::sin(angle) * a + std::cos(angle) * b;
    p[axis] = centre[axis] + 0.95 * (p[axis] - centre[axis]);
  }
  return y;
}

struct Scene {
  std::unique_ptr<Topology> topology;
  Motion motion;
  ObjectFilter filter;

  explicit Scene(int cells_along) {
    const Shape shape = block(ElementType::tetrahedron, cells_along, cells_along, cells_along);
    topology = std::make_unique<Topology>(shape.mesh());
    motion = Motion::linear(shape.positions, twisted(shape.positions));
  }
  explicit Scene(const std::string& file) {
    SequenceReader reader(file);
    SequenceCells cells;
    std::vector<Vec3> points;
    reader.read_cells(0, cells);
    reader.read_points(0, points);
    topology = std::make_unique<Topology>(mesh_of(reader.point_ids(), cells));
    motion = Motion::linear(points, twisted(points));
  }
  Step step() const { return {*topology, motion, filter}; }
};

const Scene& large_scene() {
  static const Scene scene = [] {
    const char* given = std::getenv("VOLCCD_DATA");
    const std::filesystem::path folder = given ? given : VOLCCD_SOURCE_DIR "/../shared/data";
    const std::filesystem::path file = folder / "octopus2-105k.vtkhdf";
    return std::filesystem::exists(file) ? Scene(file.string()) : Scene(26);
  }();
  return scene;
}

/// 10 368 tetrahedra, few enough for brute force.
const Scene& small_scene() {
  static const Scene scene(12);
  return scene;
}

void update(benchmark::State& timer, const StageDescriptor<BroadPhase>& descriptor, const OptionValues& options,
            const Scene& scene) {
  SerialExecutor executor;
  const auto phase = descriptor.make(options);
  const auto state = phase->make_state();
  phase->prepare(scene.step(), *state, executor);
  for (auto _ : timer) phase->prepare(scene.step(), *state, executor);
}

void query(benchmark::State& timer, const StageDescriptor<BroadPhase>& descriptor, const OptionValues& options,
           const Scene& scene, PairRange range) {
  SerialExecutor executor;
  const auto phase = descriptor.make(options);
  const auto state = phase->make_state();
  Step step = scene.step();
  step.range = range;
  phase->prepare(step, *state, executor);
  std::size_t pairs = 0;
  for (auto _ : timer) {
    pairs = 0;
    visit_candidates(*phase, step, *state, executor,
                     [&](std::span<const ElementPair> block, unsigned) { pairs += block.size(); });
  }
  timer.counters["pairs"] = static_cast<double>(pairs);
  timer.counters["pairs/s"] =
      benchmark::Counter(static_cast<double>(pairs), benchmark::Counter::kIsIterationInvariantRate);
}

#define VOLCCD_BROAD_PHASE(name, descriptor, scene, ...)                                                             \
  BENCHMARK_CAPTURE(update, name, descriptor, OptionValues{__VA_ARGS__}, scene)->Unit(benchmark::kMillisecond);      \
  BENCHMARK_CAPTURE(query, name##_nonadjacent, descriptor, OptionValues{__VA_ARGS__}, scene, PairRange::nonadjacent) \
      ->Unit(benchmark::kMillisecond);                                                                               \
  BENCHMARK_CAPTURE(query, name##_every, descriptor, OptionValues{__VA_ARGS__}, scene, PairRange::every)             \
      ->Unit(benchmark::kMillisecond)

VOLCCD_BROAD_PHASE(kdop_bvh_16, describe_kdop_bvh(), large_scene(), {"k", "16"});
VOLCCD_BROAD_PHASE(kdop_bvh_6, describe_kdop_bvh(), large_scene(), {"k", "6"});
VOLCCD_BROAD_PHASE(kdop_bvh_26, describe_kdop_bvh(), large_scene(), {"k", "26"});
VOLCCD_BROAD_PHASE(kdop_bvh_rebuilt, describe_kdop_bvh(), large_scene(), {"restructure", "always"});
VOLCCD_BROAD_PHASE(spatial_hash_16, describe_spatial_hash(), large_scene(), {"k", "16"});
VOLCCD_BROAD_PHASE(brute_force_10k, describe_brute_force(), small_scene(), {"bounds", "aabb"});
VOLCCD_BROAD_PHASE(kdop_bvh_10k, describe_kdop_bvh(), small_scene(), {"k", "16"});

}  // namespace
}  // namespace volccd
