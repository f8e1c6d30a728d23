#include "runner.hpp"

#include <cmath>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <volccd/core/error.hpp>

#include "registry.hpp"
#include "signals.hpp"

namespace volccd::python {

namespace {

ObjectFilter make_filter(const RunnerConfig& config) {
  PairScope scope = PairScope::all;
  if (config.pairs == "inter")
    scope = PairScope::inter;
  else if (config.pairs == "intra")
    scope = PairScope::intra;
  else if (config.pairs != "all")
    throw ConfigError(fmt::format("pairs: '{}' is not all, inter or intra", config.pairs));
  ObjectFilter filter(scope);
  for (const auto& [a, b] : config.exclude) filter.exclude(a, b);
  return filter;
}

}  // namespace

RunnerConfig::RunnerConfig(const py::dict& options)
    : pipeline(options["pipeline"].cast<std::string>()),
      settings(options["settings"].cast<std::vector<std::string>>()),
      threads(options["threads"].cast<unsigned>()),
      separation(options["separation"].cast<double>()),
      pairs(options["pairs"].cast<std::string>()),
      exclude(options["exclude"].cast<std::vector<std::pair<std::int32_t, std::int32_t>>>()) {}

Runner::Runner(const RunnerConfig& config)
    : pipeline_(registry(), make_spec(registry(), config.pipeline, config.settings)),
      workspace_(pipeline_.make_workspace()),
      executor_(make_signal_executor(config.threads)),
      filter_(make_filter(config)) {
  set_separation(config.separation);
}

void Runner::set_separation(double separation) {
  if (!(separation >= 0) || !std::isfinite(separation))
    throw ConfigError(fmt::format("separation: {} is not a finite number >= 0", separation));
  separation_ = separation;
}

std::shared_ptr<Result> Runner::run(const Topology& topology, const Motion& motion, const StepRequest& request,
                                    bool shell_neighbours_left_out) {
  if (!(request.t_max >= 0 && request.t_max <= 1))
    throw ConfigError(fmt::format("t_max: {} is not within 0 .. 1", request.t_max));
  Step step{topology, motion, filter_, separation_};
  step.t_max = request.t_max;
  const Request asked(request.first ? Query::first : Query::all, request.initial_overlaps, shell_neighbours_left_out);
  auto result = std::make_shared<Result>();
  pipeline_.run(step, workspace_, *executor_, *result, asked);
  return result;
}

py::dict runner_facts(Runner& runner) {
  const PipelineSpec& spec = runner.pipeline().spec();
  py::list stages;
  for (const auto& [role, choice] : spec.stages())
    stages.append(py::make_tuple(role, choice->name, py::cast(choice->options)));
  return py::dict(py::arg("pipeline") = spec.name, py::arg("guarantee") = to_string(runner.pipeline().guarantee()),
                  py::arg("threads") = runner.executor().workers(), py::arg("stages") = stages);
}

}  // namespace volccd::python
