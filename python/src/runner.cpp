#include "runner.hpp"

#include <utility>
#include <vector>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <volccd/core/error.hpp>
#include <volccd/core/named_values.hpp>

namespace volccd::python {

namespace {

/// "off", "auto", or a budget and a number of steps.
ListConfig lists_from(const py::object& lists) {
  if (!py::isinstance<py::str>(lists)) {
    const auto [budget, steps] = lists.cast<std::pair<double, double>>();
    return {.use = ListConfig::Use::always, .budget = budget, .steps = steps};
  }
  const auto word = lists.cast<std::string>();
  if (word == "off") return {};
  if (word == "auto") return {.use = ListConfig::Use::automatic};
  throw ConfigError(fmt::format("lists: '{}' is not off, auto, or a pair (budget, steps)", word));
}

}  // namespace

DetectorConfig detector_config(const py::dict& options) {
  DetectorConfig config{.pipeline = options["pipeline"].cast<std::string>(),
                        .settings = options["settings"].cast<std::vector<std::string>>(),
                        .threads = options["threads"].cast<unsigned>(),
                        .separation = options["separation"].cast<double>(),
                        .filter = ObjectFilter(value_named<PairScope>(options["pairs"].cast<std::string>(), "pairs")),
                        .lists = lists_from(options["lists"])};
  for (const auto& [a, b] : options["exclude"].cast<std::vector<std::pair<std::int32_t, std::int32_t>>>())
    config.filter.exclude(a, b);
  return config;
}

py::dict facts_of(const Pipeline& pipeline, const Executor& executor) {
  const PipelineSpec& spec = pipeline.spec();
  py::list stages;
  for (const auto& [role, choice] : spec.stages())
    stages.append(py::make_tuple(role, choice->name, py::cast(choice->options)));
  return py::dict(py::arg("pipeline") = spec.name, py::arg("guarantee") = to_string(pipeline.guarantee()),
                  py::arg("threads") = executor.workers(), py::arg("stages") = stages);
}

}  // namespace volccd::python
