// A list of tests that contains all contacts of the motions near a predicted one.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/mesh/topology_delta.hpp>
#include <volccd/pipelines/lists/detail/local_candidates.hpp>
#include <volccd/pipelines/lists/detail/predicted_motion.hpp>
#include <volccd/pipelines/pipeline.hpp>

namespace volccd {

/// Theorem. Let P be a motion, s >= 0 a separation and b >= 0 a budget. If a motion q is within b of P
/// (detail::PredictedMotion), every two features that come within s of each other under q come within S = s + 2 b of
/// each other under P. So the tests that a conservative pipeline finds for P with the separation S contain every
/// contact of q with the separation s. Proof: at the time t of the contact, two points of the features are at most s
/// apart; their weights in the vertices are at least 0 and add up to 1, so that under P, at the time of P that belongs
/// to t, each of the two points is at most b from where it is under q. (docs/candidate_lists.md)
///
/// The tests are those that all feature filters of the pipeline keep, but for those that leave tests to others. Removed
/// features leave the list. Vertices of added features get new lines in P, and their tests are found anew, if they are
/// few: the list is then *refreshed*.
///
/// Within the list are inner ones, each for an eighth of the budget of the one around it: steps that are so near to P
/// perform their tests only.
/// Not thread-safe.
class CandidateList {
 public:
  /// Makes the list anew, by a run of the pipeline on the motion that goes on from that of the step for `steps` steps
  /// (0: that rests at its end). The budget is a distance, finite and >= 0, in the unit of the coordinates. Returns
  /// whether there is a list, and that it covers the step itself; there is none where coordinates are too large for
  /// bounds of rounding. Pre: the pipeline is exact or conservative. Throws what Pipeline::run throws; then there is no
  /// list.
  bool build(const Pipeline& pipeline, const Step& step, Workspace& workspace, Executor& executor, double steps,
             double budget);

  /// Whether the list contains all contacts of the step, after the edits of the topology since it was made; it may be
  /// refreshed for that. If not, there is no list afterwards. The step has the object filter of the list, and leaves
  /// out shell neighbours if it did. O(vertices), and O(elements + list) after edits. Throws as build().
  bool covers(const Pipeline& pipeline, const Step& step, Executor& executor);

  /// s + 2 b, rounded up.
  static double separation(double s, double budget);

  bool empty() const { return !made_; }
  void clear() { made_ = false; }
  /// Tests that contain all contacts of the step that the list was made for, or covered last.
  const TestBatch& tests() const {
    std::size_t i = 0;
    while (i + 1 < lists_ && distance_ <= budget_of(i + 1)) ++i;
    return tests_[i];
  }
  /// How often the list was refreshed since it was made.
  int refreshed() const { return refreshed_; }
  double budget() const { return budget_; }
  /// By how much the last step that was compared with the list is away from its prediction.
  double distance() const { return distance_; }
  /// The time of the prediction, from 0 to 1, at which that step ended.
  double prediction_time() const { return prediction_time_; }

  std::size_t bytes() const {
    std::size_t sum = heap_bytes(prediction_, delta_, gone_, local_, renewed_);
    for (const TestBatch& tests : tests_) sum += heap_bytes(tests.vf, tests.ee);
    return sum;
  }

 private:
  static constexpr std::size_t kLists = 3;

  double budget_of(std::size_t list) const { return std::ldexp(budget_, -3 * static_cast<int>(list)); }
  bool follow_edits(const Step& step);
  void add_changed_vertices(const Step& step, const TopologyChange& change);
  bool is_near(const Step& step, Executor& executor);
  bool refresh(const Pipeline& pipeline, const Step& step, Executor& executor);

  detail::PredictedMotion prediction_;
  TopologyDelta delta_;
  std::array<TestBatch, kLists> tests_;  ///< of the list, then of inner ones
  std::size_t lists_ = 0;                ///< how many of them there are
  std::vector<std::uint8_t> gone_;       ///< by slot: scratch memory
  detail::LocalCandidates local_;
  std::vector<Index> renewed_;  ///< vertices whose tests are to be found anew
  bool made_ = false;
  int refreshed_ = 0;
  double separation_ = 0, budget_ = 0, distance_ = 0, prediction_time_ = 0;
};

}  // namespace volccd
