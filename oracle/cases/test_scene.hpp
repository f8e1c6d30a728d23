// Single tests as a step for filters and narrow phases.
#pragma once

#include <vector>

#include <volccd/oracle/cases/near_degenerate.hpp>
#include <volccd/oracle/cases/query_set.hpp>

namespace volccd::cases {

/// Holds `tests` tests, each on a separate tetrahedron. Setting a test changes the motion but not the topology.
class TestScene {
 public:
  explicit TestScene(Index tests = 1)
      : topology_(separate_tetrahedra(tests)), motions_{Motion(4 * tests, 2), Motion(4 * tests, 3)} {}

  void set(Index i, const Case& c) {
    Motion& motion = motions_[static_cast<std::size_t>(c.control_points - 2)];
    for (Index v = 0; v < 4; ++v)
      for (int k = 0; k < c.control_points; ++k) {
        const Curve& p = v < c.own(0) ? c.sets[0][v] : c.sets[1][v - c.own(0)];
        motion.set(4 * i + v, k, p[static_cast<std::size_t>(k)]);
      }
  }
  Step step(int control_points, double separation, double t_max) const {
    return {topology_, motions_[static_cast<std::size_t>(control_points - 2)], everything_, separation, t_max};
  }
  FeaturePair pair(FeatureKind kind, Index i) const {
    const Features& f = topology_.features();
    const Index v = 4 * i;
    if (kind == FeatureKind::vf) return {v, f.find_triangle(v + 1, v + 2, v + 3)};
    return {f.find_edge(v, v + 1), f.find_edge(v + 2, v + 3)};
  }

 private:
  Topology topology_;
  Motion motions_[2];
  ObjectFilter everything_;
};

}  // namespace volccd::cases
