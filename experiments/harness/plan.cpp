#include <volccd/experiments/harness/plan.hpp>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <limits>

#include <volccd/io/stats_json.hpp>

namespace volccd {

using nlohmann::json;

std::vector<StepWindow> sampled_windows(int steps, int count, int length) {
  if (steps <= count * length) return {{0, steps}};
  std::vector<StepWindow> windows;
  const int places = steps - 1;  // step 1 and later
  for (int i = 0; i < count; ++i) {
    const int middle = 1 + static_cast<int>((i + 0.5) * places / count);
    const int first = std::clamp(middle - length / 2, 1, steps - length);
    if (windows.empty() || first >= windows.back().first + windows.back().count) windows.push_back({first, length});
  }
  return windows;
}

std::vector<StepWindow> with_an_edit(std::vector<StepWindow> windows, int steps, const std::vector<int>& edits) {
  const auto contains = [](const StepWindow& window, int step) {
    return step >= window.first && step < window.first + window.count;
  };
  int nearest = std::numeric_limits<int>::max();
  std::size_t chosen = 0;
  StepWindow moved;
  for (const int edit : edits)
    for (std::size_t i = 0; i < windows.size(); ++i) {
      const StepWindow& window = windows[i];
      if (contains(window, edit)) return windows;
      const int low = i > 0 ? windows[i - 1].first + windows[i - 1].count : 1;
      const int high = (i + 1 < windows.size() ? windows[i + 1].first : steps) - window.count;
      if (low > high) continue;
      const StepWindow there{std::clamp(edit - window.count / 2, low, high), window.count};
      const int distance = std::abs(there.first - window.first);
      if (contains(there, edit) && distance < nearest) nearest = distance, chosen = i, moved = there;
    }
  if (nearest < std::numeric_limits<int>::max()) windows[chosen] = moved;
  return windows;
}

std::vector<StepWindow> all_windows(int steps, int length) {
  std::vector<StepWindow> windows;
  for (int first = 0; first < steps; first += length) windows.push_back({first, std::min(length, steps - first)});
  return windows;
}

int rounds_of(const ExperimentPlan& plan, const SceneRun& run) { return run.rounds > 0 ? run.rounds : plan.rounds; }

std::pair<int, int> rounds_of_process(const ExperimentPlan& plan, const SceneRun& run, int process) {
  const int rounds = rounds_of(plan, run);
  return {rounds * process / plan.processes, rounds * (process + 1) / plan.processes};
}

std::size_t measured_runs(const ExperimentPlan& plan) {
  std::size_t sum = 0;
  for (const SceneRun& run : plan.runs)
    for (const StepWindow& window : run.windows)
      sum +=
          static_cast<std::size_t>(window.count) * run.entrants.size() * static_cast<std::size_t>(rounds_of(plan, run));
  return sum;
}

json to_json(const ExperimentPlan& plan) {
  json runs = json::array();
  for (const SceneRun& run : plan.runs) {
    json windows = json::array(), entrants = json::array();
    for (const StepWindow& window : run.windows) windows.push_back({window.first, window.count});
    for (const Entrant& entrant : run.entrants)
      entrants.push_back({{"table", entrant.table},
                          {"pipeline", entrant.pipeline},
                          {"variant", entrant.variant},
                          {"on_boundary", entrant.on_boundary},
                          {"without_separation", entrant.without_separation},
                          {"stages", to_json(entrant.spec)}});
    runs.push_back({{"scene", run.scene},
                    {"file", std::filesystem::path(run.file).filename().string()},
                    {"motion_model", name_of(run.config.motion)},
                    {"shells", name_of(run.config.shells)},
                    {"edges", name_of(run.config.edge_set)},
                    {"windows", windows},
                    {"entrants", entrants},
                    {"rounds", rounds_of(plan, run)},
                    {"threads", run.threads},
                    {"motion_scale", run.motion_scale},
                    {"subdivisions", run.subdivisions},
                    {"columns", run.columns}});
  }
  return {{"experiment", plan.name},
          {"setting", plan.setting},
          {"rounds", plan.rounds},
          {"processes", plan.processes},
          {"runs", runs}};
}

}  // namespace volccd
