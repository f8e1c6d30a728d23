#include <volccd/experiments/tables/comparison.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <volccd/experiments/records/stats_json.hpp>
#include <volccd/experiments/tables/median.hpp>
#include <volccd/experiments/tables/text_table.hpp>
#include <volccd/pipelines/compare.hpp>

namespace volccd {

using nlohmann::json;

namespace {

/// The paper's elementary tests in all pipelines.
PipelineSpec with_cubic(const Registry& registry, const std::string& name) {
  PipelineSpec spec = registry.pipeline(name);
  registry.apply_setting(spec, "narrow-phase=cubic");
  return spec;
}

struct Contestant {
  Contestant(const Registry& registry, const std::string& name)
      : pipeline(registry, with_cubic(registry, name)), workspace(pipeline.make_workspace()) {}
  Pipeline pipeline;
  Workspace workspace;
  std::vector<Statistics> rounds;  ///< of the present step
  StepResult result;
};

/// The round whose time is the (upper) median.
Statistics median_round(std::vector<Statistics>& rounds) {
  const auto middle = rounds.begin() + static_cast<std::ptrdiff_t>(rounds.size() / 2);
  std::nth_element(rounds.begin(), middle, rounds.end(),
                   [](const Statistics& x, const Statistics& y) { return x.seconds < y.seconds; });
  return *middle;
}

/// "step 0 + 0.99329": the first step with a contact, and its time within it.
std::string earliest(const PipelineRecord& record) {
  for (std::size_t k = 0; k < record.steps.size(); ++k)
    if (std::isfinite(record.steps[k].earliest_toi)) return fmt::format("{} + {:.6f}", k, record.steps[k].earliest_toi);
  return "-";
}

std::string ratio(double value) { return value >= 100 ? fmt::format("{:.0f}x", value) : fmt::format("{:.3g}x", value); }

}  // namespace

Statistics PipelineRecord::total() const {
  Statistics sum;
  for (const Statistics& step : steps) sum += step;
  return sum;
}

double PipelineRecord::median_seconds() const {
  std::vector<double> seconds;
  for (const Statistics& step : steps) seconds.push_back(step.seconds);
  return median(seconds);
}

void compare_pipelines(const Registry& registry, SequenceStepper& stepper, const ComparisonConfig& config,
                       Executor& executor, ComparisonRecord& record) {
  const ObjectFilter everything;
  record = {config.sequence, config.rounds, executor.workers(), {}};
  record.compared.end = stepper.motion_count();
  std::vector<std::unique_ptr<Contestant>> contestants;
  for (const std::string& name : config.pipelines) {
    contestants.push_back(std::make_unique<Contestant>(registry, name));
    record.pipelines.push_back({name, to_json(contestants.back()->pipeline), {}, true});
  }
  const std::size_t total =
      static_cast<std::size_t>(stepper.motion_count()) * contestants.size() * static_cast<std::size_t>(config.rounds);
  std::size_t done = 0;
  for (int k = 0; k < stepper.motion_count(); ++k) {
    stepper.go_to(k);
    const Step step{stepper.topology(), stepper.motion(), everything};
    for (int round = k == 0 ? -1 : 0; round < config.rounds; ++round)
      for (const auto& contestant : contestants) {
        if (config.progress) config.progress(done, total);
        contestant->pipeline.run(step, contestant->workspace, executor, contestant->result);
        if (round < 0) continue;
        contestant->rounds.push_back(contestant->result.statistics);
        ++done;
      }
    for (std::size_t i = 0; i < contestants.size(); ++i) {
      PipelineRecord& pipeline = record.pipelines[i];
      pipeline.steps.push_back(median_round(contestants[i]->rounds));
      contestants[i]->rounds.clear();
      if (!compare_contacts(contestants[0]->result.contacts, contestants[i]->result.contacts).empty())
        pipeline.same_contacts = false;
    }
    record.compared.done = k + 1;
  }
}

json ComparisonRecord::to_json() const {
  json list = json::array();
  for (const PipelineRecord& pipeline : pipelines) {
    json steps = json::array();
    for (const Statistics& step : pipeline.steps) steps.push_back(volccd::to_json(step));
    list.push_back({{"pipeline", pipeline.configuration},
                    {"median_seconds", pipeline.median_seconds()},
                    {"same_contacts", pipeline.same_contacts},
                    {"total", volccd::to_json(pipeline.total())},
                    {"steps", steps}});
  }
  return {{"sequence", sequence},
          {"complete", compared.complete()},
          {"steps_asked", {compared.begin, compared.end}},
          {"steps_done", compared.done - compared.begin},
          {"stopped_by", compared.complete() ? json(nullptr) : json(compared.stopped_by)},
          {"rounds", rounds},
          {"threads", threads},
          {"machine", machine_facts()},
          {"pipelines", list}};
}

std::string comparison_table(const ComparisonRecord& record) {
  const auto find = [&](const std::string& name) -> const PipelineRecord* {
    for (const PipelineRecord& pipeline : record.pipelines)
      if (pipeline.name == name) return &pipeline;
    return nullptr;
  };
  const PipelineRecord *nav = find("NavCCD"), *hash = find("HashCCD");
  const auto speed_up = [](const PipelineRecord* baseline, const PipelineRecord& pipeline) {
    return baseline && pipeline.median_seconds() > 0 ? ratio(baseline->median_seconds() / pipeline.median_seconds())
                                                     : std::string("-");
  };
  TextTable table({"pipeline", "time/step", "vs NavCCD", "vs HashCCD", "element pairs", "VF tests", "EE tests",
                   "culling ratio", "contacts", "earliest (step + t)", "same contacts"});
  for (const PipelineRecord& pipeline : record.pipelines) {
    const Statistics sum = pipeline.total();
    const std::string culling = nav ? fmt::format("{:.3g} %", 100.0 * static_cast<double>(sum.tests()) /
                                                                  static_cast<double>(nav->total().tests()))
                                    : "-";
    table.add({pipeline.name, duration(pipeline.median_seconds()), speed_up(nav, pipeline), speed_up(hash, pipeline),
               grouped(sum.element_pairs), grouped(sum.vf_tests), grouped(sum.ee_tests), culling, grouped(sum.contacts),
               earliest(pipeline), pipeline.same_contacts ? "yes" : "NO"});
  }
  table.rule();
  table.add({"paper, bullet (Table I)", "48 ms", "21x", "28x", "-", "-", "-", "0.69 %", "-", "-", "-"});
  return table.text();
}

std::string share_table(const ComparisonRecord& record) {
  const std::vector<std::pair<std::string, std::string>> roles = {
      {BroadPhase::kRole, "broad phase"},        {ElementCulling::kRole, "element culling"},
      {Assignment::kRole, "assignment"},         {OrphanSource::kRole, "O-Set"},
      {FeatureFilter::kRole, "feature filters"}, {NarrowPhase::kRole, "elementary tests"}};
  std::vector<std::string> header = {"share of time, %", "prepare"};
  for (const auto& [role, title] : roles) header.push_back(title);
  header.push_back("remainder");
  TextTable table(header);
  for (const PipelineRecord& pipeline : record.pipelines) {
    const Statistics sum = pipeline.total();
    std::map<std::string, double> seconds;
    double prepare = 0, attributed = 0;
    for (const StageStatistics& stage : sum.stages) {
      prepare += stage.prepare_seconds;
      seconds[stage.role] += stage.seconds;
      attributed += stage.all_seconds();
    }
    const double all = std::max(sum.seconds * record.threads, 1e-300);
    std::vector<std::string> row = {pipeline.name, fmt::format("{:.1f}", 100 * prepare / all)};
    for (const auto& [role, title] : roles)
      row.push_back(seconds.contains(role) ? fmt::format("{:.1f}", 100 * seconds[role] / all) : "-");
    row.push_back(fmt::format("{:.1f}", 100 * (all - attributed) / all));
    table.add(row);
  }
  return table.text();
}

}  // namespace volccd
