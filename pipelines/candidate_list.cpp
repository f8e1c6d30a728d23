#include <volccd/pipelines/candidate_list.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace volccd {

namespace {

/// Removes the tests whose first feature, or second one, is in a list.
void remove_tests(std::vector<FeaturePair>& tests, Index FeaturePair::*which, std::span<const Index> features,
                  std::vector<std::uint8_t>& gone) {
  if (features.empty()) return;
  gone.assign(std::size_t{features.back()} + 1, 0);
  for (const Index f : features) gone[f] = 1;
  std::erase_if(tests, [&](FeaturePair pair) { return pair.*which < gone.size() && gone[pair.*which] != 0; });
}

}  // namespace

double CandidateList::separation(double s, double budget) {
  return std::nextafter(s + 2 * budget, std::numeric_limits<double>::infinity());
}

bool CandidateList::build(const Pipeline& pipeline, const Step& step, Workspace& workspace, Executor& executor,
                          double steps, double budget) {
  made_ = false;
  budget_ = budget;
  separation_ = step.separation;
  if (!prediction_.set(step.motion, steps, step.features())) return false;
  delta_.sync(step.topology);
  delta_.confirm();
  if (!is_near(step, executor)) return false;
  const Step ahead{.topology = step.topology,
                   .motion = prediction_.lines(),
                   .filter = step.filter,
                   .separation = separation(step.separation, budget)};
  StepResult result;
  pipeline.run(ahead, workspace, executor, result, {.count_adjacent = false, .candidates = &tests_});
  made_ = true;
  return true;
}

bool CandidateList::covers(const Step& step, Executor& executor) {
  made_ = made_ && step.separation <= separation_ && follow_edits(step) && is_near(step, executor);
  return made_;
}

bool CandidateList::is_near(const Step& step, Executor& executor) {
  const auto at = prediction_.nearest(step.motion);
  reached_ = at.end;
  distance_ = prediction_.distance(step.motion, step.features(), at, executor);
  return distance_ <= budget_;
}

/// False if an edit adds features, or elements of features.
bool CandidateList::follow_edits(const Step& step) {
  if (delta_.sync(step.topology) == TopologyDelta::Extent::everything) return false;
  for (const TopologyChange* change : delta_.changes()) {
    if (!change->added_elements.empty()) return false;
    const FeatureChange& features = change->features;
    remove_tests(tests_.vf, &FeaturePair::a, features.removed_vertices, gone_);
    remove_tests(tests_.vf, &FeaturePair::b, features.removed_triangles, gone_);
    remove_tests(tests_.ee, &FeaturePair::a, features.removed_edges, gone_);
    remove_tests(tests_.ee, &FeaturePair::b, features.removed_edges, gone_);
  }
  if (prediction_.lines().vertex_count() != step.motion.vertex_count()) return false;
  delta_.confirm();
  return true;
}

}  // namespace volccd
