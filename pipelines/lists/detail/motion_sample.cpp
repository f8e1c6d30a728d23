#include <volccd/pipelines/lists/detail/motion_sample.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace volccd::detail {

namespace {

constexpr Index kVertices = 256, kEdges = 64;
/// A motion that is this many greatest budgets away from its prediction is another one.
constexpr double kJump = 4;
constexpr double kUnknown = std::numeric_limits<double>::infinity();

/// The mean length of some edges at the start of the step.
double mean_edge(const Step& step) {
  const Features& features = step.features();
  const Index stride = features.edge_slots() / kEdges + 1;
  double sum = 0;
  Index count = 0;
  for (Index e = 0; e < features.edge_slots(); e += stride) {
    if (features.first_element_of_edge(e) == kNone) continue;
    sum += (step.motion.point(features.edge(e)[0], 0) - step.motion.point(features.edge(e)[1], 0)).norm();
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

}  // namespace

void MotionSample::begin(const Step& step) {
  const Motion& motion = step.motion;
  vertices_ = motion.vertex_count();
  stride_ = vertices_ / kVertices + 1;
  while (std::gcd(stride_, Index{6}) != 1) ++stride_;  // numbers of copies, of which some are not used, are often such
  starts_.clear();
  ways_.clear();
  for (Index v = 0; v < vertices_; v += stride_) {
    starts_.emplace_back(motion.point(v, 0));
    ways_.emplace_back(motion.point(v, motion.control_points() - 1) - starts_.back());
  }
  edge_ = mean_edge(step);
  steps_ = 1;
  distance_ = 0;
}

ListPolicy::Motion MotionSample::compare(const Step& step, const ListPolicy& policy) {
  const Motion& motion = step.motion;
  const int last = motion.control_points() - 1;
  const bool known = !starts_.empty() && motion.vertex_count() >= vertices_;
  if (!known) begin(step);
  const auto visit = [&](auto&& with) {
    for (std::size_t i = 0; i < starts_.size(); ++i)
      if (const auto v = static_cast<Index>(i * stride_); step.features().first_element_of_vertex(v) != kNone)
        with(motion.point(v, 0), motion.point(v, last), starts_[i], ways_[i]);
  };
  double length = 0, first = 0, second = 0, squares = 0;
  visit([&](const Vec3& from, const Vec3& to, const Vec3& start, const Vec3& way) {
    length = std::max(length, (to - from).norm());
    first += way.dot(from - start);
    second += way.dot(to - start);
    squares += way.squaredNorm();
  });
  if (!known) return {length, kUnknown, 1, edge_};
  const auto time = [&](double sum) { return squares > 0 ? std::max(sum / squares, 0.0) : 0; };
  const double t0 = time(first), t1 = time(second), steps = std::max(t1 - 1, 1.0), budget = policy.max_budget() * edge_;
  double distance = distance_;
  visit([&](const Vec3& from, const Vec3& to, const Vec3& start, const Vec3& way) {
    distance = std::max({distance, (from - start - t0 * way).norm(), (to - start - t1 * way).norm()});
  });
  if (distance <= budget) steps_ = std::max(steps_, steps), distance_ = distance;
  const ListPolicy::Motion found{length, distance <= kJump * budget ? distance_ : kUnknown, steps_, edge_};
  if (distance > distance_ || steps * length > policy.max_travel() * edge_) begin(step);
  return found;
}

}  // namespace volccd::detail
