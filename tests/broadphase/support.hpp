// Scenes, collection of pairs, and an oracle in exact integers for the tests of broad phases.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_int.hpp>

#include <volccd/broadphase/broad_phase.hpp>
#include <volccd/broadphase/brute_force.hpp>
#include <volccd/broadphase/kdop_bvh.hpp>
#include <volccd/broadphase/spatial_hash.hpp>
#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/query/kdop.hpp>
#include <volccd/query/pairs.hpp>

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

/// Runs a query, checks its batches, and returns the pairs in ascending order.
inline Pairs query(const BroadPhase& phase, const Step& step, StageState& state, PairRange range, Executor& executor) {
  std::mutex mutex;
  Pairs pairs;
  phase.run(step, state, range, executor, [&](std::span<const ElementPair> batch, unsigned worker) {
    const std::lock_guard lock(mutex);
    EXPECT_LE(batch.size(), BroadPhase::kMaxBatch);
    EXPECT_GT(batch.size(), 0u);
    EXPECT_LT(worker, executor.workers());
    pairs.insert(pairs.end(), batch.begin(), batch.end());
  });
  std::sort(pairs.begin(), pairs.end());
  EXPECT_EQ(std::adjacent_find(pairs.begin(), pairs.end()), pairs.end()) << "a pair came out twice";
  for (const ElementPair& pair : pairs) EXPECT_LE(pair.a, pair.b);
  return pairs;
}

inline Pairs run(const BroadPhase& phase, const Step& step, StageState& state, PairRange range, Executor& executor) {
  phase.prepare(step, state, executor);
  return query(phase, step, state, range, executor);
}

inline Pairs run_fresh(const BroadPhase& phase, const Step& step, PairRange range = PairRange::every) {
  SerialExecutor executor;
  const auto state = phase.make_state();
  return run(phase, step, *state, range, executor);
}

/// x * 2^1074, which is an integer for every finite double.
using Exact = boost::multiprecision::cpp_int;
inline Exact exact(double x) {
  int exponent = 0;
  const double fraction = std::frexp(x, &exponent);
  Exact value = static_cast<std::int64_t>(std::ldexp(fraction, 53));
  const int shift = exponent - 53 + 1074;
  if (shift >= 0) return value << static_cast<unsigned>(shift);
  return value / (Exact(1) << static_cast<unsigned>(-shift));  // exact, because denormals have trailing zeros
}

/// Exact projections of each element's control points, computed by simple loops.
class KdopOracle {
 public:
  KdopOracle(const Step& step, int k) : step_(step) {
    with_axes(k);
    const Mesh& mesh = step.mesh();
    lo_.resize(mesh.element_slots());
    hi_.resize(mesh.element_slots());
    for (Index o = 0; o < mesh.element_slots(); ++o)
      for (const auto& axis : axes_) {
        bool first = true;
        Exact lo, hi;
        for (Index v : mesh.vertices(o))
          for (int c = 0; c < step.motion.control_points(); ++c) {
            const Vec3 p = step.motion.point(v, c);
            const Exact s = axis[0] * exact(p[0]) + axis[1] * exact(p[1]) + axis[2] * exact(p[2]);
            if (first || s < lo) lo = s;
            if (first || s > hi) hi = s;
            first = false;
          }
        lo_[o].push_back(lo);
        hi_[o].push_back(hi);
      }
    separation_ = exact(step.separation);
  }

  /// Whether the intervals come within the separation (times the axis's length) on every axis, in exact arithmetic.
  bool overlap(Index a, Index b) const {
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      const Exact gap = std::max<Exact>(lo_[a][i] - hi_[b][i], lo_[b][i] - hi_[a][i]);
      if (gap > 0 && gap * gap > separation_ * separation_ * axis_terms(axes_[i])) return false;
    }
    return true;
  }

  /// Whether the intervals are apart on some axis, within the range of floats, by more than the separation, `relative`
  /// of their magnitude, and the smallest step of a float.
  bool clearly_apart(Index a, Index b, double relative, double absolute) const {
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      const Exact gap = std::max<Exact>(lo_[a][i] - hi_[b][i], lo_[b][i] - hi_[a][i]);
      if (gap <= 0) continue;
      double magnitude = step_.separation * 2;
      for (const Exact& e : {lo_[a][i], hi_[a][i], lo_[b][i], hi_[b][i]})
        magnitude = std::max(magnitude, std::abs(to_double(e)));
      if (!(magnitude < 1e38)) continue;
      const double allowed =
          step_.separation * std::sqrt(double(axis_terms(axes_[i]))) + relative * magnitude + absolute;
      if (to_double(gap) > allowed) return true;
    }
    return false;
  }

 private:
  void with_axes(int k) {
    const auto take = [&](const auto& axes) { axes_.assign(axes.begin(), axes.end()); };
    switch (k) {
      case 6: take(kdop_axes<6>()); break;
      case 14: take(kdop_axes<14>()); break;
      case 16: take(kdop_axes<16>()); break;
      case 18: take(kdop_axes<18>()); break;
      case 24: take(kdop_axes<24>()); break;
      default: take(kdop_axes<26>()); break;
    }
  }
  /// e / 2^1074, with an error of about 1e-15; infinity beyond the range.
  static double to_double(const Exact& e) {
    if (e == 0) return 0;
    const Exact magnitude = boost::multiprecision::abs(e);
    const unsigned bits = boost::multiprecision::msb(magnitude);
    const unsigned drop = bits > 62 ? bits - 62 : 0;
    const double value = std::ldexp(static_cast<double>(static_cast<std::int64_t>(magnitude >> drop)),
                                    static_cast<int>(drop) - 1074);
    return e < 0 ? -value : value;
  }

  const Step step_;
  std::vector<std::array<int, 3>> axes_;
  std::vector<std::vector<Exact>> lo_, hi_;
  Exact separation_;
};

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
