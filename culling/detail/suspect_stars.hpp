// Base of the classes that find the stars that may fold in a step.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/culling/detail/boundary_rings.hpp>
#include <volccd/culling/detail/star_table.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// What is known of a star (that the star and its ring surround the vertex once) can change only at times when one of
/// its volumes is 0 or its ring folds, or by a change of the topology. It remains known from step to step if neither
/// occurs throughout both steps and, if the next step does not begin at the positions where the last one ended,
/// throughout the straight motion between them. Not thread-safe; uses the executor.
class SuspectStars {
 public:
  /// Whether the star of v is not clear: it is not proven to remain embedded throughout the step.
  bool suspect(Index v) const { return suspect_[v] != 0; }
  const std::vector<Index>& suspects() const { return suspects_; }  ///< suspect vertices, ascending

 protected:
  /// Begins an update. Returns what has changed since the last update that ended; an interrupted one leaves nothing.
  TopologyDelta::Extent begin(TopologyDelta::Extent changed) {
    return std::exchange(complete_, false) ? changed : TopologyDelta::Extent::everything;
  }

  /// Sets folds_ for the step, and forgets the stars that changed or may have folded before it; forget_by_signs(way)
  /// forgets those with volumes whose signs differ in the motion `way` between the steps.
  template <class Table, class ForgetBySigns>
  void keep_known(const Step& step, const Table& table, TopologyDelta::Extent changed, Executor& executor,
                  ForgetBySigns&& forget_by_signs) {
    if (changed != TopologyDelta::Extent::none) rings_.set_faces(step.mesh(), table.boundary_faces(step.topology));
    if (changed == TopologyDelta::Extent::everything) known_.clear(), last_.clear();
    known_.resize(step.motion.vertex_count(), 0);
    suspect_.resize(known_.size());
    scratch_.resize(executor.workers());
    forget(table.changed_vertices());
    if (find_way(step.motion, executor)) {
      const Step way{step.topology, way_, step.filter};
      rings_.find_folds(way, executor, folds_);
      for (std::size_t v = 0; v < known_.size(); ++v)
        if (folds_[v] != 0) known_[v] = 0;
      forget_by_signs(way);
    }
    rings_.find_folds(step, executor, folds_);
  }

  void forget(std::span<const Index> vertices) {
    for (const Index v : vertices) known_[v] = 0;
  }

  /// Ends an update that has set suspect_.
  void finish() {
    suspects_.clear();
    for (Index v = 0; v < suspect_.size(); ++v)
      if (suspect_[v] != 0) suspects_.push_back(v);
    complete_ = true;
  }

  std::size_t stars_bytes() const {
    return heap_bytes(rings_, folds_, suspect_, known_, scratch_, last_, start_, end_, way_, suspects_);
  }

  BoundaryRings rings_;
  std::vector<std::uint8_t> folds_, suspect_, known_;  ///< by vertex
  std::vector<Ring> scratch_;                          ///< by worker

 private:
  /// Takes the next step. Returns whether it does not begin where the last one ended; way_ is the motion in between.
  /// Vertices that the last step did not have do not move in it. False for the first step.
  bool find_way(const Motion& motion, Executor& executor) {
    constexpr std::size_t kGrain = 4096;
    const std::size_t before = last_.size(), vertices = motion.vertex_count();
    for (std::vector<Vec3>* positions : {&start_, &last_, &end_}) positions->resize(vertices);
    std::atomic<bool> moved = false;
    executor.parallel_for(vertices, kGrain, [&](std::size_t begin, std::size_t end, unsigned) {
      bool here = false;
      for (std::size_t v = begin; v < end; ++v) {
        start_[v] = motion.point(static_cast<Index>(v), 0);
        end_[v] = motion.point(static_cast<Index>(v), motion.control_points() - 1);
        if (v >= before) last_[v] = start_[v];
        here = here || last_[v] != start_[v];
      }
      if (here) moved.store(true, std::memory_order_relaxed);
    });
    if (moved) way_.set_linear(last_, start_);
    last_.swap(end_);
    return moved;
  }

  std::vector<Vec3> last_, start_, end_;
  Motion way_;
  std::vector<Index> suspects_;
  bool complete_ = false;  ///< whether the last update has ended
};

}  // namespace volccd::detail
