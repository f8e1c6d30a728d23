// Pairs of elements whose control points can be set, for tests of CSAT.
#pragma once

#include <volccd/mesh/topology.hpp>
#include <volccd/query/roles/element_culling.hpp>

#include "filter_touching.hpp"

namespace volccd::test {

/// `pairs` disjoint pairs of elements of one type: pair i is (2i, 2i + 1).
class PairBench {
 public:
  PairBench(ElementType type, int control_points, Index pairs = 64)
      : n_(static_cast<Index>(volccd::vertex_count(type))),
        pairs_(pairs),
        topology_(make_mesh(type, pairs)),
        motion_(topology_.mesh().vertex_count(), control_points) {}

  Index vertices() const { return n_; }
  Index pairs() const { return pairs_; }
  /// Vertex i of element 2 * pair + side.
  Index vertex(Index pair, Index side, Index i) const { return (2 * pair + side) * n_ + i; }
  void set(Index pair, Index side, Index i, int c, const Vec3& p) { motion_.set(vertex(pair, side, i), c, p); }
  Step step(double separation = 0, double t_max = 1) const { return {topology_, motion_, filter_, separation, t_max}; }
  const Motion& motion() const { return motion_; }
  const Features& features() const { return topology_.features(); }

  PairBatch batch(bool swapped = false) const {
    PairBatch batch;
    for (Index i = 0; i < pairs_; ++i)
      batch.pairs.push_back(swapped ? ElementPair{2 * i + 1, 2 * i} : ElementPair{2 * i, 2 * i + 1});
    batch.masks.resize(pairs_);
    return batch;
  }

 private:
  Mesh make_mesh(ElementType type, Index pairs) const {
    Mesh mesh;
    mesh.add_vertices(2 * pairs * n_);
    for (Index o = 0; o < 2 * pairs; ++o) {
      ElementSpec element;
      element.type = type;
      element.id = o;
      for (Index i = 0; i < n_; ++i) element.vertices.push_back(o * n_ + i);
      mesh.add_element(element);
    }
    return mesh;
  }

  Index n_, pairs_;
  Topology topology_;
  Motion motion_;
  ObjectFilter filter_;
};

/// Elements in balls of diameter 1 on both sides of a random plane, at least `gap` apart at every control point
/// (negative: up to this depth inside each other), with random motions and a common one.
inline void set_apart(PairBench& bench, Random& random, double gap) {
  for (Index i = 0; i < bench.pairs(); ++i) {
    const Vec3 n = random.vector(-1, 1).normalized(), drift = random.vector(-3, 3);
    for (int c = 0; c < bench.motion().control_points(); ++c)
      for (Index side = 0; side < 2; ++side)
        for (Index v = 0; v < bench.vertices(); ++v) {
          const Vec3 p = random.vector(-0.5, 0.5);
          const double height = (side == 0 ? -1 : 1) * (gap / 2 + random.uniform(0, 1));
          bench.set(i, side, v, c, p + (height - p.dot(n)) * n + c * drift);
        }
  }
}

}  // namespace volccd::test
