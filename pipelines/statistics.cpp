#include <volccd/pipelines/statistics.hpp>

#include <algorithm>
#include <cassert>

namespace volccd {

namespace {

void add_counters(std::vector<StageCounter>& counters, const std::vector<StageCounter>& others) {
  for (const StageCounter& other : others) {
    const auto own = std::ranges::find(counters, std::string_view(other.name), &StageCounter::name);
    if (own != counters.end())
      own->value += other.value;
    else
      counters.push_back(other);
  }
}

}  // namespace

double StageStatistics::counter(std::string_view which) const {
  const auto found = std::ranges::find(counters, which, &StageCounter::name);
  return found == counters.end() ? 0 : found->value;
}

Statistics& Statistics::operator+=(const Statistics& other) {
  steps += other.steps;
  list_steps += other.list_steps;
  refreshed_steps += other.refreshed_steps;
  reused_steps += other.reused_steps;
  list_tests += other.list_tests;
  list_budget = std::max(list_budget, other.list_budget);
  list_seconds += other.list_seconds;
  element_pairs += other.element_pairs;
  adjacent_pairs += other.adjacent_pairs;
  surviving_pairs += other.surviving_pairs;
  owned_tests += other.owned_tests;
  orphan_tests += other.orphan_tests;
  vf_tests += other.vf_tests;
  ee_tests += other.ee_tests;
  contacts += other.contacts;
  contacts_at_start += other.contacts_at_start;
  initial_overlaps += other.initial_overlaps;
  duplicates += other.duplicates;
  degenerate += other.degenerate;
  undecided += other.undecided;
  earliest_toi = std::min(earliest_toi, other.earliest_toi);
  seconds += other.seconds;
  workspace_bytes = std::max(workspace_bytes, other.workspace_bytes);
  if (stages.empty()) {
    stages = other.stages;
    return *this;
  }
  assert(stages.size() == other.stages.size());
  for (std::size_t i = 0; i < stages.size(); ++i) {
    stages[i].in += other.stages[i].in;
    stages[i].out += other.stages[i].out;
    stages[i].prepare_seconds += other.stages[i].prepare_seconds;
    add_counters(stages[i].counters, other.stages[i].counters);
    stages[i].seconds += other.stages[i].seconds;
  }
  return *this;
}

}  // namespace volccd
