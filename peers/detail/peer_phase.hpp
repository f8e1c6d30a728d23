// Common base of all adaptors: the input of the other library is the swept boxes, its output the positions of
// overlapping boxes.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <volccd/broadphase/detail/filter_keys.hpp>
#include <volccd/broadphase/detail/pair_writer.hpp>
#include <volccd/broadphase/detail/swept_bounds.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/mesh/topology_delta.hpp>
#include <volccd/query/roles/broad_phase.hpp>

namespace volccd::detail {

/// Base of the state of an adaptor, which adds the data structure of the other library.
struct PeerState : StageState {
  TopologyDelta delta;
  FilterKeys keys;
  std::vector<Index> slots;     ///< live elements, ascending
  BoundsTable vertices, boxes;  ///< k = 6; row p of `boxes` is the swept box of the element at position p of `slots`
  std::vector<std::vector<ElementPair>> pairs;     ///< by worker: all pairs of the step, without self pairs
  std::vector<std::array<std::size_t, 2>> chunks;  ///< of `pairs`: worker and begin
  const PairRules* rules = nullptr;                ///< those of the step, while collide() runs
  double bounds_seconds = 0;
  float scale = 1;

  const float* low(std::size_t position) const { return boxes.row(position); }
  const float* high(std::size_t position) const { return boxes.row(position) + boxes.width(); }

  /// Whether two closed boxes overlap or touch.
  bool overlap(Index p, Index q) const {
    const float *a = low(p), *b = low(q), *c = high(p), *d = high(q);
    return a[0] <= d[0] && b[0] <= c[0] && a[1] <= d[1] && b[1] <= c[1] && a[2] <= d[2] && b[2] <= c[2];
  }

  /// Passes on a pair of positions whose boxes overlap, if the query requests it.
  void push(Index p, Index q, unsigned worker = 0) {
    const Index a = slots[p], b = slots[q];
    if (rules->included(a, b)) pairs[worker].push_back(ordered(a, b));
  }

  /// Sets `scale` for libraries that compute volumes in floats: to 1, or if some coordinate exceeds 1e12, to a power of
  /// two that makes all floats smaller. Scaled boxes of overlapping boxes overlap; other boxes may overlap too, because
  /// small coordinates lose digits.
  void set_scale();

  /// Bytes of the other library's data structure, as far as they can be determined.
  virtual std::size_t peer_bytes() const = 0;
  std::size_t bytes() const final;
};

/// Base of the adaptors. Their state objects are of type PeerState. The other library finds all pairs in blocks(), and
/// run() hands them out.
class PeerPhase : public BroadPhase {
 public:
  void prepare(const Step& step, StageState& state, Executor& executor) const final;
  std::size_t blocks(const Step& step, StageState& state, Executor& executor) const final;
  void run(const Step& step, StageState& state, unsigned worker, std::size_t block, Work& work) const final;
  void append_counters(const StageState& state, std::vector<StageCounter>& out) const final;

 protected:
  /// Updates the other library's data structure for the boxes of the state. `changed`: the boxes belong to other
  /// elements than in the last call, or this is the first call. There may be no elements.
  virtual void update(PeerState& state, bool changed, Executor& executor) const = 0;

  /// Passes each unordered pair of different positions whose boxes overlap or touch to state.push(), exactly once, with
  /// the number of the worker that finds it. There are at least two elements.
  virtual void collide(PeerState& state, Executor& executor) const = 0;
};

/// Each function is defined only if its library is available.
StageDescriptor<BroadPhase> describe_fcl_dynamic_tree();
StageDescriptor<BroadPhase> describe_bullet_dbvt();
StageDescriptor<BroadPhase> describe_embree_collide();
StageDescriptor<BroadPhase> describe_cgal_box_intersection();

}  // namespace volccd::detail
