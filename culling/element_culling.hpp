// The element-culling strategy: drops element pairs, or masks features of a pair, that cannot touch during the step.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <volccd/core/stage.hpp>
#include <volccd/query/step.hpp>

namespace volccd {

/// Features of an element pair (a,b) that were shown not to touch the other element. Bit i of `vertices_a`: vertex i of a
/// (node order) touches no triangle of b; bit i of `edges_a`: edge i of a (Features::element_edges) touches no edge of b;
/// likewise for b. Features beyond the bits are never masked: large polytopes are merely culled less.
struct FeatureMask {
  std::uint32_t vertices_a = 0, vertices_b = 0;
  std::uint64_t edges_a = 0, edges_b = 0;
};

/// Structure of arrays: masks.size() == pairs.size(). Reused from batch to batch, so that nothing is allocated in steady
/// state.
struct PairBatch {
  std::vector<ElementPair> pairs;
  std::vector<FeatureMask> masks;

  std::size_t size() const { return pairs.size(); }
  void clear() {
    pairs.clear();
    masks.clear();
  }
};

class ElementCulling {
 public:
  virtual ~ElementCulling() = default;

  /// Whether a pair is dropped only if the convex hulls of its elements are proven to stay further apart than
  /// step.separation all through [0, step.t_max]. "No feature touches another", which is all that cull() must know, is less: an
  /// element may lie inside another, or pierce it between its edges.
  virtual bool drops_only_disjoint() const { return false; }

  /// State shared by all batches and workers of a step; nullptr if none is needed.
  virtual std::unique_ptr<StageState> make_state() const { return nullptr; }
  /// Once a step, before the first batch, on one thread. `state` is what make_state() made.
  virtual void update(const Step& step, StageState* state) const {
    (void)step;
    (void)state;
  }

  /// Takes pairs that do not touch during [0, step.t_max] out of the batch (keeping the order of the rest), and adds bits to
  /// masks. Pairs of adjacent elements and of an element with itself may occur; their shared features must stay. Called
  /// concurrently for different batches.
  virtual void cull(const Step& step, StageState* state, PairBatch& batch) const = 0;
};

}  // namespace volccd
