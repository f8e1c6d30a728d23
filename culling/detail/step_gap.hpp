// The motion between the end of a step and the start of the next one.
#pragma once

#include <cstddef>
#include <vector>

#include <volccd/query/motion.hpp>

namespace volccd::detail {

/// A property that can change only together with the sign of a polynomial of the positions remains known from step to
/// step if the sign is the same throughout both steps and, if the next step does not begin at the positions where the
/// last one ended, throughout the straight motion between them. Not thread-safe.
class StepGap {
 public:
  /// Forgets the last step.
  void clear() { last_.clear(); }
  bool empty() const { return last_.empty(); }

  /// Takes the next step. Returns whether it does not begin where the last one ended; way() is the motion in between.
  /// Vertices that the last step did not have do not move in it. False for the first step.
  bool update(const Motion& motion) {
    const bool first = last_.empty();
    const Index vertices = motion.vertex_count();
    start_.resize(vertices);
    bool moved = false;
    for (Index v = 0; v < vertices; ++v) {
      start_[v] = motion.point(v, 0);
      if (v >= last_.size()) last_.push_back(start_[v]);
      moved = moved || last_[v] != start_[v];
    }
    moved = moved && !first;
    if (moved) way_.set_linear(last_, start_);
    for (Index v = 0; v < vertices; ++v) last_[v] = motion.point(v, motion.control_points() - 1);
    return moved;
  }
  const Motion& way() const { return way_; }

  std::size_t bytes() const { return (last_.capacity() + start_.capacity()) * sizeof(Vec3) + way_.bytes(); }

 private:
  std::vector<Vec3> last_, start_;
  Motion way_;
};

}  // namespace volccd::detail
