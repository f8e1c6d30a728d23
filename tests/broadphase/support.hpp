// Scenes, collection of pairs, and their comparison with the oracle, for the tests of broad phases.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/broadphase/brute_force.hpp>
#include <volccd/broadphase/candidate_pairs.hpp>
#include <volccd/broadphase/kdop_bvh.hpp>
#include <volccd/broadphase/spatial_hash.hpp>
#include <volccd/numerics/kdop.hpp>
#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/query/pairs.hpp>
#include <volccd/query/roles/broad_phase.hpp>

#include "broadphase/kdop_oracle.hpp"

namespace volccd::test {

using Pairs = std::vector<ElementPair>;

/// A topology, a motion, and the options of a query.
struct Scene {
  std::string name;
  std::unique_ptr<Topology> topology;
  Motion motion;
  ObjectFilter filter;
  double separation = 0;

  Step step() const { return {*topology, motion, filter, separation}; }
};

inline Scene make_scene(std::string name, const Shape& shape, const std::vector<Vec3>& x1) {
  Scene scene;
  scene.name = std::move(name);
  scene.topology = std::make_unique<Topology>(shape.mesh());
  scene.motion = Motion::linear(shape.positions, x1);
  return scene;
}

inline std::vector<Vec3> scaled(std::vector<Vec3> positions, double by) {
  for (Vec3& p : positions) p *= by;
  return positions;
}

inline std::unique_ptr<BroadPhase> make(const StageDescriptor<BroadPhase>& descriptor,
                                        const OptionValues& values = {}) {
  return descriptor.make(values);
}

/// Runs a query, checks that no pair is repeated, and returns the pairs in ascending order.
inline Pairs query(const BroadPhase& phase, Step step, StageState& state, PairRange range, Executor& executor) {
  step.range = range;
  const Pairs pairs = candidate_pairs(phase, step, state, executor);
  EXPECT_EQ(std::adjacent_find(pairs.begin(), pairs.end()), pairs.end()) << "a pair came out twice";
  for (const ElementPair& pair : pairs) EXPECT_LE(pair.a, pair.b);
  return pairs;
}

inline Pairs run(const BroadPhase& phase, Step step, StageState& state, PairRange range, Executor& executor) {
  step.range = range;
  phase.prepare(step, state, executor);
  return query(phase, step, state, range, executor);
}

inline Pairs run_fresh(const BroadPhase& phase, const Step& step, PairRange range = PairRange::every) {
  SerialExecutor executor;
  const auto state = phase.make_state();
  return run(phase, step, *state, range, executor);
}

/// All unordered pairs of live elements that a query for this range must give if its bounds never separate a pair.
inline Pairs all_pairs(const Step& step, PairRange range) {
  const Mesh& mesh = step.mesh();
  Pairs pairs;
  for (Index a = 0; a < mesh.element_slots(); ++a)
    for (Index b = a; b < mesh.element_slots(); ++b) {
      if (!mesh.is_live(a) || !mesh.is_live(b) || step.filter.drops(step.topology, {a, b})) continue;
      if (range == PairRange::nonadjacent) {
        bool shared = false;
        for (Index v : mesh.vertices(a))
          for (Index w : mesh.vertices(b)) shared |= v == w;
        if (shared) continue;
      }
      pairs.push_back({a, b});
    }
  return pairs;
}

/// Checks pairs with the oracle: every exact overlap is included, and no pair that is clearly apart.
inline void expect_sound(const Pairs& pairs, const KdopOracle& oracle, const Step& step, PairRange range,
                         double relative = 0x1p-21, double absolute = 0x1p-146) {
  const Pairs owed = all_pairs(step, range);
  ASSERT_TRUE(std::includes(owed.begin(), owed.end(), pairs.begin(), pairs.end())) << "a pair that nobody asked for";
  std::size_t missing = 0, extra = 0;
  for (const ElementPair& pair : owed) {
    const bool there = std::binary_search(pairs.begin(), pairs.end(), pair);
    if (!there && oracle.overlap(pair.a, pair.b)) ++missing;
    if (there && oracle.clearly_apart(pair.a, pair.b, relative, absolute)) ++extra;
  }
  EXPECT_EQ(missing, 0u) << "overlapping pairs are missing";
  EXPECT_EQ(extra, 0u) << "pairs that are clearly apart";
}

}  // namespace volccd::test
