// The motion between the end of a step and the start of the next one.
#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/query/motion.hpp>

namespace volccd::detail {

/// A property that can change only together with the sign of a polynomial of the positions remains known from step to
/// step if the sign is the same throughout both steps and, if the next step does not begin at the positions where the
/// last one ended, throughout the straight motion between them. Not thread-safe; uses the executor.
class StepGap {
 public:
  /// Forgets the last step.
  void clear() { last_.clear(); }
  bool empty() const { return last_.empty(); }

  /// Takes the next step. Returns whether it does not begin where the last one ended; way() is the motion in between.
  /// Vertices that the last step did not have do not move in it. False for the first step.
  bool update(const Motion& motion, Executor& executor) {
    const std::size_t known = last_.size(), vertices = motion.vertex_count();
    start_.resize(vertices);
    last_.resize(vertices);
    end_.resize(vertices);
    std::atomic<bool> moved = false;
    executor.parallel_for(vertices, kGrain, [&](std::size_t begin, std::size_t end, unsigned) {
      bool here = false;
      for (std::size_t v = begin; v < end; ++v) {
        start_[v] = motion.point(static_cast<Index>(v), 0);
        end_[v] = motion.point(static_cast<Index>(v), motion.control_points() - 1);
        if (v >= known) last_[v] = start_[v];
        here = here || last_[v] != start_[v];
      }
      if (here) moved.store(true, std::memory_order_relaxed);
    });
    if (moved) way_.set_linear(last_, start_);
    last_.swap(end_);
    return moved;
  }
  const Motion& way() const { return way_; }

  std::size_t bytes() const {
    return (last_.capacity() + start_.capacity() + end_.capacity()) * sizeof(Vec3) + way_.bytes();
  }

 private:
  static constexpr std::size_t kGrain = 4096;

  std::vector<Vec3> last_, start_, end_;
  Motion way_;
};

}  // namespace volccd::detail
