// What all adaptors share: swept boxes go in, positions of overlapping boxes come out.
#pragma once

#include <cstddef>

#include <volccd/broadphase/broad_phase.hpp>
#include <volccd/broadphase/detail/element_list.hpp>
#include <volccd/broadphase/detail/filter_keys.hpp>
#include <volccd/broadphase/detail/pair_writer.hpp>
#include <volccd/broadphase/detail/swept_bounds.hpp>

namespace volccd::detail {

/// An adaptor's state derives from it, and holds the peer's structure besides.
struct PeerState : StageState {
  ElementDelta delta;
  FilterKeys keys;
  ElementList list;  ///< live elements by slot, no gaps
  BoundsTable vertices, boxes;  ///< k = 6; row p of `boxes` is the swept box of the element at position p of the list
  PairWriters writers;
  double bounds_seconds = 0;

  const float* low(std::size_t position) const { return boxes.row(position); }
  const float* high(std::size_t position) const { return boxes.row(position) + boxes.width(); }

  /// Closed boxes, touching included.
  bool overlap(Index p, Index q) const {
    const float *a = low(p), *b = low(q), *c = high(p), *d = high(q);
    return a[0] <= d[0] && b[0] <= c[0] && a[1] <= d[1] && b[1] <= c[1] && a[2] <= d[2] && b[2] <= c[2];
  }

  /// For peers that compute volumes in floats: 1, or where some coordinate exceeds 1e12, a power of two that brings all
  /// floats below it. Scaled boxes of overlapping boxes overlap, but others may, too: small coordinates are lost.
  float safe_scale() const;

  /// Of the peer's structure, as far as it can be told.
  virtual std::size_t peer_bytes() const = 0;
  std::size_t bytes() const final;
};

/// Where an adaptor puts the pairs that its peer finds: those that the query wants go on. One for each worker.
class PeerOutput {
 public:
  PeerOutput(const PairRules& rules, const Index* slots, PairWriter& writer)
      : rules_(&rules), slots_(slots), writer_(&writer) {}

  /// Two positions whose boxes overlap.
  void push(Index p, Index q) const {
    const Index a = slots_[p], b = slots_[q];
    if (rules_->want(a, b)) writer_->push(a, b);
  }

 private:
  const PairRules* rules_;
  const Index* slots_;
  PairWriter* writer_;
};

/// Base of the adaptors. State objects are PeerState.
class PeerPhase : public BroadPhase {
 public:
  void prepare(const Step& step, StageState& state, Executor& executor) const final;
  void run(const Step& step, StageState& state, PairRange range, Executor& executor, PairSink sink) const final;
  double bounds_seconds(const StageState& state) const final;

 protected:
  /// Brings the peer's structure up to the boxes of the state. `changed`: they belong to other elements than at the
  /// last call, or there was none. The list may be empty.
  virtual void update(PeerState& state, bool changed, Executor& executor) const = 0;

  /// Hands each unordered pair of different positions whose boxes overlap, touching included, to the output of
  /// the worker that finds it (state.writers), once. The list has two elements or more.
  virtual void collide(PeerState& state, const PairRules& rules, Executor& executor) const = 0;
};

/// Each is there if its library is.
StageDescriptor<BroadPhase> describe_fcl_dynamic_tree();
StageDescriptor<BroadPhase> describe_bullet_dbvt();
StageDescriptor<BroadPhase> describe_embree_collide();
StageDescriptor<BroadPhase> describe_cgal_box_intersection();

}  // namespace volccd::detail
