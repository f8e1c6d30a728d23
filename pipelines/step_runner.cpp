#include <volccd/pipelines/step_runner.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/pipelines/stage_clock.hpp>

namespace volccd {

namespace {

/// The time that the tests of a list took which found nothing, summed over workers.
double time_in_vain(const Statistics& statistics) {
  const auto found = static_cast<double>(statistics.contacts);
  double seconds = 0;
  for (const StageStatistics& stage : statistics.stages)
    if (stage.in > 0) seconds += stage.seconds * (1 - std::min(1.0, found / static_cast<double>(stage.in)));
  return seconds;
}

}  // namespace

StepRunner::StepRunner(Pipeline pipeline, RunConfig config)
    : pipeline_(std::move(pipeline)),
      workspace_(pipeline_.make_workspace()),
      own_executor_(config.executor ? nullptr : make_executor(config.threads)),
      executor_(config.executor ? config.executor : own_executor_.get()),
      filter_(std::move(config.filter)),
      leave_out_shell_neighbours_(config.leave_out_shell_neighbours),
      lists_(config.lists) {
  set_separation(config.separation);
  if (lists_.use == ListConfig::Use::never) return;
  if (pipeline_.guarantee() == Guarantee::approximate)
    throw ConfigError(
        fmt::format("candidate lists: pipeline {} may lose contacts, and so would its lists", pipeline_.spec().name));
  if (!(lists_.budget >= 0) || !std::isfinite(lists_.budget))
    throw ConfigError(fmt::format("candidate lists: budget {} is not a finite number >= 0", lists_.budget));
  if (!(lists_.steps >= 0) || !std::isfinite(lists_.steps))
    throw ConfigError(fmt::format("candidate lists: {} steps: not a finite number >= 0", lists_.steps));
}

const StepResult& StepRunner::run(const Topology& topology, const Motion& motion, const Request& request, double t_max,
                                  const Piece& piece) {
  if (!(t_max >= 0 && t_max <= 1)) throw ConfigError(fmt::format("t_max: {} is not within 0 .. 1", t_max));
  Step step{topology, motion, filter_, separation_};
  step.t_max = t_max;
  step.leave_out_shell_neighbours = leave_out_shell_neighbours_;
  step.piece = piece;
  // Observers, initial overlaps and candidates need the stages that a list leaves out.
  if (lists_.use == ListConfig::Use::never || request.observer || request.initial_overlaps || request.candidates ||
      request.tests) {
    pipeline_.run(step, workspace_, *executor_, result_, request);
    return result_;
  }
  double list_seconds = 0;
  try {
    compare_motion(step, list_seconds);
    if (!reuse_list(step, request, list_seconds) && !make_list(step, request, list_seconds)) {
      pipeline_.run(step, workspace_, *executor_, result_, request);
      policy_.record_fresh(result_.statistics.seconds);
    }
  } catch (...) {
    list_.clear();
    sample_.clear();
    throw;
  }
  result_.statistics.list_seconds = list_seconds;
  result_.statistics.seconds += list_seconds;
  return result_;
}

/// Sets moved_ where the policy needs it.
void StepRunner::compare_motion(const Step& step, double& list_seconds) {
  if (lists_.use != ListConfig::Use::automatic) return;
  StageClock clock;
  const StageTimer timer(clock, list_seconds);
  moved_ = sample_.compare(step, policy_);
}

/// Runs the tests of the list, if it contains all contacts of the step. Adds the time that the list takes.
bool StepRunner::reuse_list(const Step& step, const Request& request, double& list_seconds) {
  if (list_.empty()) return false;
  bool covered = false;
  {
    StageClock clock;
    const StageTimer timer(clock, list_seconds);
    covered = list_.covers(pipeline_, step, *executor_);
  }
  if (!covered) {
    policy_.record_end(distance_, list_.prediction_time() < 1 ? list_.distance() : 0, list_seconds);
    return false;
  }
  distance_ = std::max(distance_, list_.distance());
  run_tests(step, request, list_seconds);
  const bool refreshed = list_.refreshed() > std::exchange(refreshed_, list_.refreshed());
  ++(refreshed ? result_.statistics.refreshed_steps : result_.statistics.reused_steps);
  return true;
}

/// Makes a list and runs its tests, if a list is wanted and possible. Adds the time that the list takes.
bool StepRunner::make_list(const Step& step, const Request& request, double& list_seconds) {
  std::optional<ListPolicy::Plan> plan = ListPolicy::Plan{lists_.steps, lists_.budget};
  if (lists_.use == ListConfig::Use::automatic) plan = policy_.plan(moved_);
  if (!plan) return false;
  double build = 0;
  bool made = false;
  {
    StageClock clock;
    const StageTimer timer(clock, build);
    made = list_.build(pipeline_, step, workspace_, *executor_, plan->steps, plan->budget);
  }
  list_seconds += build;
  policy_.record_list(build);
  if (!made) return false;
  distance_ = 0;
  refreshed_ = 0;
  if (lists_.use == ListConfig::Use::automatic) sample_.begin(step);
  run_tests(step, request, 0);
  ++result_.statistics.list_steps;
  return true;
}

/// `list_seconds`: the time that the list took in this step, besides making it.
void StepRunner::run_tests(const Step& step, Request request, double list_seconds) {
  request.tests = &list_.tests();
  pipeline_.run(step, workspace_, *executor_, result_, request);
  Statistics& statistics = result_.statistics;
  statistics.list_tests = list_.tests().size();
  statistics.list_budget = list_.budget();
  policy_.record_use(list_seconds + statistics.seconds, time_in_vain(statistics) / executor_->workers());
  if (lists_.use == ListConfig::Use::automatic && !policy_.is_worthwhile()) {
    policy_.record_end(distance_, 0, 0);
    list_.clear();
  }
}

StepResult StepRunner::release_result() { return std::exchange(result_, {}); }

void StepRunner::set_separation(double separation) {
  if (!(separation >= 0) || !std::isfinite(separation))
    throw ConfigError(fmt::format("separation: {} is not a finite number >= 0", separation));
  separation_ = separation;
}

}  // namespace volccd
