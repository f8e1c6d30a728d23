// What a few vertices tell about a motion: how fast it is, and whether it goes on as the one before it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/pipelines/lists/list_policy.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// Compares some vertices and edges, evenly spaced among the slots, from step to step. Not thread-safe.
class MotionSample {
 public:
  /// Compares the motion with that of the last call. O(1).
  ListPolicy::Motion compare(const Step& step);
  /// The next step is compared with no other one.
  void forget() { ends_.clear(); }

  std::size_t bytes() const { return heap_bytes(ends_, ways_); }

 private:
  std::vector<Vec3> ends_, ways_;  ///< of the sampled vertices in the last step
};

}  // namespace volccd::detail
