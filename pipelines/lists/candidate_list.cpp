#include <volccd/pipelines/lists/candidate_list.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include <volccd/core/sort_unique.hpp>

namespace volccd {

namespace {

/// A list is refreshed for at most this many vertices.
constexpr std::size_t kMaxRenewed = 64;

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
  Step ahead{.topology = step.topology,
             .motion = prediction_.lines(),
             .filter = step.filter,
             .separation = separation(step.separation, budget),
             .leave_out_shell_neighbours = step.leave_out_shell_neighbours,
             .piece = {.complete = step.piece.complete, .cut_stars = step.piece.cut_stars}};
  StepResult result;
  pipeline.run(ahead, workspace, executor, result, {.count_adjacent = false, .candidates = &tests_[0]});
  for (lists_ = 1; lists_ < kLists; ++lists_) {
    ahead.separation = separation(step.separation, budget_of(lists_));
    pipeline.run(ahead, workspace, executor, result,
                 {.count_adjacent = false, .tests = &tests_[lists_ - 1], .candidates = &tests_[lists_]});
  }
  refreshed_ = 0;
  made_ = true;
  return true;
}

bool CandidateList::covers(const Pipeline& pipeline, const Step& step, Executor& executor) {
  const bool valid = std::exchange(made_, false);  // there is no list if an exception is thrown
  made_ = valid && step.separation <= separation_ && follow_edits(step) &&
          (renewed_.empty() ? is_near(step, executor) : refresh(pipeline, step, executor));
  return made_;
}

bool CandidateList::is_near(const Step& step, Executor& executor) {
  const auto at = prediction_.nearest(step.motion);
  prediction_time_ = at.end;
  distance_ = prediction_.distance(step.motion, step.features(), at, executor);
  return distance_ <= budget_;
}

/// Removes the tests of removed features, and sets renewed_ to the vertices of features that edits added.
bool CandidateList::follow_edits(const Step& step) {
  renewed_.clear();
  if (delta_.sync(step.topology) == TopologyDelta::Extent::everything) return false;
  for (const TopologyChange* change : delta_.changes()) {
    const FeatureChange& features = change->features;
    for (TestBatch& tests : std::span(tests_).first(lists_)) {
      remove_tests(tests.vf, &FeaturePair::a, features.removed_vertices, gone_);
      remove_tests(tests.vf, &FeaturePair::b, features.removed_triangles, gone_);
      remove_tests(tests.ee, &FeaturePair::a, features.removed_edges, gone_);
      remove_tests(tests.ee, &FeaturePair::b, features.removed_edges, gone_);
    }
    if (!change->added_elements.empty()) add_changed_vertices(step, *change);
  }
  for (Index v = prediction_.lines().vertex_count(); v < step.motion.vertex_count(); ++v) renewed_.push_back(v);
  sort_unique(renewed_);
  delta_.confirm();
  return true;
}

/// The vertices of the features that an edit added. With an object filter also those of features whose elements
/// changed: their pairs may be asked for only now. A feature that is gone again has no vertices.
void CandidateList::add_changed_vertices(const Step& step, const TopologyChange& change) {
  const Features& features = step.features();
  const auto add = [&](std::span<const Index> vertices) {
    renewed_.insert(renewed_.end(), vertices.begin(), vertices.end());
  };
  const auto add_all = [&](const std::vector<Index>& vertices, const std::vector<Index>& edges,
                           const std::vector<Index>& triangles) {
    add(vertices);
    for (const Index e : edges)
      if (features.first_element_of_edge(e) != kNone) add(features.edge(e));
    for (const Index f : triangles)
      if (features.first_element_of_triangle(f) != kNone) add(features.triangle(f));
  };
  const FeatureChange& changed = change.features;
  add_all(changed.added_vertices, changed.added_edges, changed.added_triangles);
  if (!step.filter.trivial()) add_all(changed.touched_vertices, changed.touched_edges, changed.touched_triangles);
}

/// Finds anew the tests of the vertices in renewed_.
bool CandidateList::refresh(const Pipeline& pipeline, const Step& step, Executor& executor) {
  const auto at = prediction_.nearest(step.motion);
  if (renewed_.size() > kMaxRenewed) return false;
  if (!prediction_.renew(step.motion, at, renewed_) || !is_near(step, executor)) return false;
  gone_.assign(step.motion.vertex_count(), 0);
  for (const Index v : renewed_) gone_[v] = 1;
  const auto remove = [&](FeatureKind kind, std::vector<FeaturePair>& tests) {
    std::erase_if(tests, [&](FeaturePair pair) {
      return std::ranges::any_of(test_vertices(step.features(), kind, pair), [&](Index v) { return gone_[v] != 0; });
    });
  };
  lists_ = 1;  // until the next list
  remove(FeatureKind::vf, tests_[0].vf);
  remove(FeatureKind::ee, tests_[0].ee);
  const Step ahead{.topology = step.topology,
                   .motion = prediction_.lines(),
                   .filter = step.filter,
                   .separation = separation(separation_, budget_),
                   .leave_out_shell_neighbours = step.leave_out_shell_neighbours};
  if (!local_.find(pipeline, ahead, renewed_, executor, tests_[0])) return false;
  ++refreshed_;
  return true;
}

}  // namespace volccd
