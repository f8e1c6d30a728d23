#include <volccd/pipelines/step_runner.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/pipelines/stage_clock.hpp>

namespace volccd {

namespace {

/// From this part of its prediction on, a list may soon be used up.
constexpr double kNearEnd = 0.7;

}  // namespace

StepRunner::StepRunner(Pipeline pipeline, RunConfig config)
    : pipeline_(std::move(pipeline)),
      workspace_(pipeline_.make_workspace()),
      own_executor_(config.executor ? nullptr : make_executor(config.threads)),
      executor_(config.executor ? config.executor : own_executor_.get()),
      filter_(std::move(config.filter)),
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
                                  std::span<const std::uint8_t> complete) {
  if (!(t_max >= 0 && t_max <= 1)) throw ConfigError(fmt::format("t_max: {} is not within 0 .. 1", t_max));
  Step step{topology, motion, filter_, separation_};
  step.t_max = t_max;
  step.complete = complete;
  // Observers and initial overlaps need the stages that a list leaves out.
  if (lists_.use == ListConfig::Use::never || request.observer || request.initial_overlaps) {
    pipeline_.run(step, workspace_, *executor_, result_, request);
    return result_;
  }
  double list_seconds = 0;
  try {
    if (!reuse_list(step, request, list_seconds) && !make_list(step, request, list_seconds)) {
      pipeline_.run(step, workspace_, *executor_, result_, request);
      policy_.record_fresh(result_.statistics.seconds);
    }
  } catch (...) {
    list_.clear();
    sample_.forget();
    throw;
  }
  result_.statistics.list_seconds = list_seconds;
  result_.statistics.seconds += list_seconds;
  return result_;
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
    policy_.record_end(distance_, list_.reached() < 1 ? list_.distance() : 0, list_seconds);
    return false;
  }
  distance_ = std::max(distance_, list_.distance());
  if (list_.reached() > kNearEnd) sample_.compare(step);  // the next list can follow without a fresh step
  run_tests(step, request, list_seconds);
  const bool refreshed = list_.refreshed() > std::exchange(refreshed_, list_.refreshed());
  ++(refreshed ? result_.statistics.refreshed_steps : result_.statistics.reused_steps);
  return true;
}

/// Makes a list and runs its tests, if a list is wanted and possible. Adds the time that the list takes.
bool StepRunner::make_list(const Step& step, const Request& request, double& list_seconds) {
  std::optional<ListPolicy::Plan> plan = ListPolicy::Plan{lists_.steps, lists_.budget};
  if (lists_.use == ListConfig::Use::automatic)
    plan = policy_.has_credit() ? policy_.plan(sample_.compare(step)) : std::nullopt;
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
  const auto tests = static_cast<double>(std::max<std::uint64_t>(1, statistics.list_tests));
  const auto found = static_cast<double>(statistics.contacts + statistics.left_out);
  policy_.record_use(list_seconds + statistics.seconds, 1 - found / tests);
  if (lists_.use == ListConfig::Use::automatic && !policy_.is_worthwhile()) {
    policy_.record_end(distance_, 0, 0);
    list_.clear();
  }
}

StepResult StepRunner::take_result() { return std::exchange(result_, {}); }

void StepRunner::set_separation(double separation) {
  if (!(separation >= 0) || !std::isfinite(separation))
    throw ConfigError(fmt::format("separation: {} is not a finite number >= 0", separation));
  separation_ = separation;
}

}  // namespace volccd
