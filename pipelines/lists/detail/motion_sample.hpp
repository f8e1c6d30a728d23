// What a few vertices tell about a motion: how fast it is, and how far it gets from a prediction.
#pragma once

#include <vector>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/pipelines/lists/list_policy.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// Predicts that some vertices, evenly spaced among the slots, go on on straight lines as in one step, and compares the
/// steps after it with that: those of a solver that goes on, that vibrates, and that asks about a step again. Begins
/// anew where a list would end (ListPolicy::max_travel()). Not thread-safe.
class MotionSample {
 public:
  /// What is known about the motion of this step, and of the steps since the prediction was made, for this policy.
  /// O(1).
  ListPolicy::Motion compare(const Step& step, const ListPolicy& policy);
  /// Predicts from this step on.
  void begin(const Step& step);
  /// The next step is compared with no other one.
  void clear() { starts_.clear(); }

  std::size_t bytes() const { return heap_bytes(starts_, ways_); }

 private:
  std::vector<Vec3> starts_, ways_;  ///< of the sampled vertices in the first step; empty if there is none
  Index stride_ = 1, vertices_ = 0;  ///< of the mesh in that step
  double edge_ = 0;                  ///< a mean length there
  double steps_ = 1, distance_ = 0;  ///< the largest distance so far, and in how many steps
};

}  // namespace volccd::detail
