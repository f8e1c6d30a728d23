#include <volccd/pipelines/step_runner.hpp>

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <volccd/core/error.hpp>

namespace volccd {

StepRunner::StepRunner(Pipeline pipeline, RunConfig config)
    : pipeline_(std::move(pipeline)),
      workspace_(pipeline_.make_workspace()),
      own_executor_(config.executor ? nullptr : make_executor(config.threads)),
      executor_(config.executor ? config.executor : own_executor_.get()),
      filter_(std::move(config.filter)) {
  set_separation(config.separation);
}

const StepResult& StepRunner::run(const Topology& topology, const Motion& motion, const Request& request,
                                  double t_max) {
  if (!(t_max >= 0 && t_max <= 1)) throw ConfigError(fmt::format("t_max: {} is not within 0 .. 1", t_max));
  Step step{topology, motion, filter_, separation_};
  step.t_max = t_max;
  pipeline_.run(step, workspace_, *executor_, result_, request);
  return result_;
}

StepResult StepRunner::take_result() { return std::exchange(result_, {}); }

void StepRunner::set_separation(double separation) {
  if (!(separation >= 0) || !std::isfinite(separation))
    throw ConfigError(fmt::format("separation: {} is not a finite number >= 0", separation));
  separation_ = separation;
}

}  // namespace volccd
