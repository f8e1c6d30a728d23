// O-Set and assignment: the cost of preparing them, of a change of one per cent, and of an element pair. On
// octopus2-105k if the shared data is present, on a slender block of tetrahedra, and on a block of hexahedra.
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include <volccd/core/random.hpp>
#include <volccd/culling/assignment/all_pairs.hpp>
#include <volccd/culling/assignment/dynamic_assignment.hpp>
#include <volccd/culling/assignment/static_assignment.hpp>
#include <volccd/culling/o_set/o_set.hpp>
#include <volccd/io/sequence/cells.hpp>
#include <volccd/io/sequence/reader.hpp>
#include <volccd/oracle/cases/shapes.hpp>

#include "support/stages.hpp"

namespace volccd {
namespace {

Executor& serial() {
  static SerialExecutor executor;
  return executor;
}

enum Model { octopus, slender, hexahedra };

const Mesh& model(std::int64_t which) {
  static const Mesh meshes[] = {[] {
                                  const char* given = std::getenv("VOLCCD_DATA");
                                  const std::filesystem::path folder =
                                      given ? given : VOLCCD_SOURCE_DIR "/../shared/data";
                                  if (!std::filesystem::exists(folder / "octopus2-105k.vtkhdf")) return Mesh();
                                  SequenceReader reader((folder / "octopus2-105k.vtkhdf").string());
                                  SequenceCells cells;
                                  reader.read_cells(0, cells);
                                  return mesh_of(reader.point_ids(), cells);
                                }(),
                                permuted(block(ElementType::tetrahedron, 3, 3, 1000), 1).mesh(),
                                block(ElementType::hexahedron, 10, 10, 100).mesh()};
  return meshes[which];
}

/// Skips the benchmark if the model is not present.
bool absent(benchmark::State& state, const Mesh& mesh) {
  if (mesh.element_count() != 0) return false;
  state.SkipWithError("octopus2-105k is not there");
  return true;
}

double seconds_of(auto&& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void build(benchmark::State& state, OSetKind kind) {
  const Mesh& mesh = model(state.range(0));
  if (absent(state, mesh)) return;
  const Topology topology(mesh);
  OSet set(kind);
  for (auto _ : state) set.build(topology, serial());
  const OSetCounts counts = set.counts();
  state.counters["vf"] = static_cast<double>(counts.vf);
  state.counters["ee"] = static_cast<double>(counts.ee);
  state.counters["bytes/element"] = static_cast<double>(set.bytes()) / mesh.element_count();
}
BENCHMARK_CAPTURE(build, minimal, OSetKind::minimal)
    ->Arg(octopus)
    ->Arg(slender)
    ->Arg(hexahedra)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(build, literal, OSetKind::literal)->Arg(octopus)->Unit(benchmark::kMillisecond);

/// One per cent of the elements: at random places, or connected.
std::vector<Index> one_percent(const Topology& topology, bool scattered, Random& random) {
  const Mesh& mesh = topology.mesh();
  const std::size_t n = mesh.element_count() / 100;
  std::set<Index> chosen;
  if (scattered) {
    while (chosen.size() < n) chosen.insert(static_cast<Index>(random.below(mesh.element_count())));
    return {chosen.begin(), chosen.end()};
  }
  std::vector<Index> region{static_cast<Index>(random.below(mesh.element_count()))};
  chosen.insert(region[0]);
  for (std::size_t i = 0; i < region.size() && region.size() < n; ++i)
    for (Index v : mesh.vertices(region[i]))
      for (Index o : topology.features().vertex_elements(v))
        if (region.size() < n && chosen.insert(o).second) region.push_back(o);
  return region;
}

/// The time is that of the changes (features and O-Set); `times faster` compares it with the time to build both before
/// each change.
void change(benchmark::State& state, bool scattered, bool removal) {
  const Mesh& mesh = model(state.range(0));
  if (absent(state, mesh)) return;
  Random random(1);
  double built = 0, features = 0, o_set = 0;
  for (auto _ : state) {
    Topology topology(mesh);
    Features fresh;
    OSet set;
    built += seconds_of([&] { fresh.build(mesh); }) + seconds_of([&] { set.build(topology, serial()); });
    TopologyEdit removed, added;
    removed.removed = one_percent(topology, scattered, random);
    for (Index o : removed.removed) {
      const auto v = mesh.vertices(o);
      added.added.push_back(
          {.type = mesh.type(o), .vertices = {v.begin(), v.end()}, .object = mesh.object(o), .id = mesh.element_id(o)});
    }
    if (!removal) {
      topology.apply(removed);
      set.build(topology, serial());
    }
    const double a = seconds_of([&] { topology.apply(removal ? removed : added); });
    const double b = seconds_of([&] { set.update(topology, serial()); });
    state.SetIterationTime(a + b);
    features += a;
    o_set += b;
  }
  const auto n = static_cast<double>(state.iterations());
  state.counters["build ms"] = 1e3 * built / n;
  state.counters["features ms"] = 1e3 * features / n;
  state.counters["o-set ms"] = 1e3 * o_set / n;
  state.counters["times faster"] = built / (features + o_set);
}
BENCHMARK_CAPTURE(change, remove_scattered, true, true)
    ->Arg(octopus)
    ->Arg(slender)
    ->Arg(hexahedra)
    ->UseManualTime()
    ->Iterations(7)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(change, remove_region, false, true)
    ->Arg(octopus)
    ->Arg(slender)
    ->Arg(hexahedra)
    ->UseManualTime()
    ->Iterations(7)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(change, add_scattered, true, false)
    ->Arg(octopus)
    ->Arg(slender)
    ->Arg(hexahedra)
    ->UseManualTime()
    ->Iterations(7)
    ->Unit(benchmark::kMillisecond);

void orphans(benchmark::State& state) {
  const Mesh& mesh = model(state.range(0));
  if (absent(state, mesh)) return;
  const Topology topology(mesh);
  OSet set;
  set.build(topology, serial());
  TestBatch batch;
  std::int64_t pairs = 0;
  for (auto _ : state)
    for (std::size_t b = 0; b < set.blocks(); ++b) {
      batch.clear();
      set.append(b, batch);
      pairs += static_cast<std::int64_t>(batch.vf.size() + batch.ee.size());
      benchmark::DoNotOptimize(batch.ee.data());
    }
  state.SetItemsProcessed(pairs);
}
BENCHMARK(orphans)->Arg(octopus)->Unit(benchmark::kMillisecond);

/// Pairs of elements that are not adjacent. `near`: both are adjacent to a common element, as pairs of a broad phase
/// often are; otherwise they are drawn from the whole mesh.
std::vector<ElementPair> element_pairs(const Topology& topology, bool near, std::size_t n) {
  const Mesh& mesh = topology.mesh();
  Random random(2);
  std::vector<ElementPair> pairs;
  const auto neighbour = [&](Index o) {
    const auto vertices = mesh.vertices(o);
    const auto around = topology.features().vertex_elements(vertices[random.below(vertices.size())]);
    return around[random.below(around.size())];
  };
  while (pairs.size() < n) {
    const auto a = static_cast<Index>(random.below(mesh.element_count()));
    auto b = static_cast<Index>(random.below(mesh.element_count()));
    if (near) b = neighbour(neighbour(a));
    if (!topology.adjacency().adjacent(a, b)) pairs.push_back({std::min(a, b), std::max(a, b)});
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

void tests(benchmark::State& state, StageDescriptor<Assignment> (*describe)(), bool near) {
  const Mesh& mesh = model(state.range(0));
  if (absent(state, mesh)) return;
  const Topology topology(mesh);
  const Motion motion(mesh.vertex_count(), 2);
  const ObjectFilter filter;
  const Step step{topology, motion, filter};
  const auto assignment = describe().make({});
  const auto kept = test::prepared(*assignment, step);
  PairBatch batch;
  batch.assign(element_pairs(topology, near, 1024));
  TestBatch out;
  for (auto _ : state) {
    out.clear();
    assignment->run(step, *kept, 0, batch, out);
    benchmark::DoNotOptimize(out.ee.data());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(batch.size()));
  state.counters["tests/pair"] = static_cast<double>(out.vf.size() + out.ee.size()) / static_cast<double>(batch.size());
}
BENCHMARK_CAPTURE(tests, dynamic_near, describe_dynamic_assignment, true)->Arg(slender)->Arg(hexahedra);
BENCHMARK_CAPTURE(tests, dynamic_anywhere, describe_dynamic_assignment, false)->Arg(slender)->Arg(hexahedra);
BENCHMARK_CAPTURE(tests, static_near, describe_static_assignment, true)->Arg(slender)->Arg(hexahedra);
BENCHMARK_CAPTURE(tests, all_near, describe_all_pairs, true)->Arg(slender)->Arg(hexahedra);

}  // namespace
}  // namespace volccd
