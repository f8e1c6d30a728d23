#include <volccd/program/experiment_names.hpp>

#include <vector>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/core/suggest.hpp>

namespace volccd {

const ExperimentKind* find_kind(const std::string& name) {
  for (const ExperimentKind& kind : experiment_kinds())
    if (name == kind.name) return &kind;
  return nullptr;
}

void unknown_experiment(const char* what, const std::string& name) {
  std::vector<std::string> known;
  for (const ExperimentKind& kind : experiment_kinds()) known.emplace_back(kind.name);
  known.emplace_back(kScenesExperiment);
  known.emplace_back("all");
  throw ConfigError(
      fmt::format("no {} '{}'; there are {}{}", what, name, fmt::join(known, ", "), did_you_mean(name, known)));
}

}  // namespace volccd
