#include <volccd/pipelines/lists/detail/motion_sample.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace volccd::detail {

namespace {

constexpr Index kVertices = 256, kEdges = 64;

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

ListPolicy::Motion MotionSample::compare(const Step& step) {
  const Motion& motion = step.motion;
  const Index stride = motion.vertex_count() / kVertices + 1;
  const int last = motion.control_points() - 1;
  const bool known = ends_.size() == (motion.vertex_count() + stride - 1) / stride;
  ListPolicy::Motion found{0, known ? 0 : std::numeric_limits<double>::infinity(), mean_edge(step)};
  if (!known) ends_.clear(), ways_.clear();
  for (Index v = 0; v < motion.vertex_count(); v += stride) {
    const std::size_t i = v / stride;
    if (!known) ends_.emplace_back(Vec3::Zero()), ways_.emplace_back(Vec3::Zero());
    const Vec3 from = motion.point(v, 0), to = motion.point(v, last), way = to - from;
    if (step.features().first_element_of_vertex(v) != kNone) {
      found.length = std::max(found.length, way.norm());
      if (known) found.distance = std::max({found.distance, (from - ends_[i]).norm(), (way - ways_[i]).norm()});
    }
    ends_[i] = to;
    ways_[i] = way;
  }
  return found;
}

}  // namespace volccd::detail
