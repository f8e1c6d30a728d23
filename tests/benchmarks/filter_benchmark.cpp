// Nanoseconds of each feature filter for a test, on blocks of random tests of which some touch.
#include <algorithm>
#include <deque>
#include <random>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include <volccd/culling/filters/coplanarity_filter.hpp>
#include <volccd/culling/filters/csat_filter.hpp>
#include <volccd/culling/filters/feature_kdop_filter.hpp>
#include <volccd/oracle/cases/query_set.hpp>

namespace volccd {
namespace {

/// Disjoint tetrahedra 4i .. 4i+3, each with one VF and one EE test between its own vertices, as most orphans are.
struct Tests {
  static constexpr Index kCount = 64 * TestBlock::kCapacity;

  explicit Tests(int control_points) : topology(separate_tetrahedra(kCount)), motion(4 * kCount, control_points) {
    std::mt19937_64 engine(1);
    std::uniform_real_distribution<double> size(-1, 1);
    const auto random = [&] { return Vec3(size(engine), size(engine), size(engine)); };
    for (Index i = 0; i < kCount; ++i) {
      const Vec3 drift = random();
      for (Index v = 0; v < 4; ++v) {
        const Vec3 x = random();
        for (int c = 0; c < control_points; ++c) motion.set(4 * i + v, c, x + c * drift + 0.1 * random());
      }
    }
  }

  std::deque<TestBlock> blocks(FeatureKind kind) const {
    const Features& features = topology.features();
    std::deque<TestBlock> all(kCount / TestBlock::kCapacity);
    for (std::size_t b = 0; b < all.size(); ++b) {
      std::vector<FeaturePair> pairs;
      for (std::size_t k = 0; k < TestBlock::kCapacity; ++k) {
        const Index v = 4 * static_cast<Index>(b * TestBlock::kCapacity + k);
        const Index e = features.find_edge(v, v + 1), f = features.find_edge(v + 2, v + 3);
        pairs.push_back(kind == FeatureKind::vf ? FeaturePair{v, features.find_triangle(v + 1, v + 2, v + 3)}
                                                : FeaturePair{std::min(e, f), std::max(e, f)});
      }
      all[b].gather({topology, motion, filter}, kind, pairs);
    }
    return all;
  }

  Topology topology;
  Motion motion;
  ObjectFilter filter;
};

const Tests& tests(int control_points) {
  static const Tests two(2), three(3);
  return control_points == 2 ? two : three;
}

void run(benchmark::State& state, const StageDescriptor<FeatureFilter>& stage, const OptionValues& options,
         FeatureKind kind, int control_points) {
  const auto filter = stage.make(options);
  const Tests& all = tests(control_points);
  const auto blocks = all.blocks(kind);
  std::vector<std::uint8_t> keep(TestBlock::kCapacity);
  StageState none;
  std::size_t kept = 0, rounds = 0;
  for (auto _ : state) {
    for (const TestBlock& block : blocks) {
      std::fill(keep.begin(), keep.end(), std::uint8_t{1});
      filter->run({all.topology, all.motion, all.filter}, none, 0, block, keep);
      for (const auto k : keep) kept += k;
    }
    ++rounds;
  }
  const auto done = static_cast<double>(rounds) * Tests::kCount;
  state.counters["per_test"] = benchmark::Counter(done, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["kept"] = static_cast<double>(kept) / done;
}

void add(const StageDescriptor<FeatureFilter>& stage, const OptionValues& options) {
  for (const auto kind : {FeatureKind::vf, FeatureKind::ee})
    for (const int control_points : {2, 3}) {
      std::string name = stage.name;
      for (const auto& [key, value] : options) name += "/" + key + ":" + value;
      name += std::string(kind == FeatureKind::vf ? "/VF" : "/EE") + "/points:" + std::to_string(control_points);
      benchmark::RegisterBenchmark(name.c_str(), run, stage, options, kind, control_points);
    }
}

[[maybe_unused]] const bool registered = [] {
  for (const char* k : {"6", "14", "16", "18", "24", "26"}) add(describe_feature_kdop_filter(), {{"k", k}});
  add(describe_feature_kdop_filter(), {{"k", "18"}, {"bounds", "swept"}});
  add(describe_coplanarity_filter(), {});
  for (const char* axes : {"first", "ends", "wide"}) add(describe_csat_filter(), {{"axes", axes}});
  return true;
}();

}  // namespace
}  // namespace volccd
