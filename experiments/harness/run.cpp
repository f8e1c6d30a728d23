#include <volccd/experiments/harness/run.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include <volccd/experiments/harness/motion_measures.hpp>
#include <volccd/experiments/harness/subdivide.hpp>
#include <volccd/experiments/records/stats_json.hpp>
#include <volccd/pipelines/pipeline.hpp>

namespace volccd {

using nlohmann::json;

namespace {

/// Nanoseconds are as fine as the clock.
double rounded(double seconds) { return std::round(seconds * 1e9) / 1e9; }

json columns_of(const Statistics& statistics) {
  json row = {{"seconds", rounded(statistics.seconds)},
              {"element_pairs", statistics.element_pairs},
              {"surviving_pairs", statistics.surviving_pairs},
              {"owned_tests", statistics.owned_tests},
              {"orphan_tests", statistics.orphan_tests},
              {"vf_tests", statistics.vf_tests},
              {"ee_tests", statistics.ee_tests},
              {"contacts", statistics.contacts},
              {"contacts_at_start", statistics.contacts_at_start},
              {"left_out", statistics.left_out},
              {"degenerate", statistics.degenerate},
              {"undecided", statistics.undecided},
              {"earliest_toi", std::isfinite(statistics.earliest_toi) ? json(statistics.earliest_toi) : json(nullptr)},
              {"workspace_bytes", statistics.workspace_bytes}};
  std::map<std::string, std::pair<double, double>> roles = {{BroadPhase::kRole, {}},    {ElementCulling::kRole, {}},
                                                            {Assignment::kRole, {}},    {OrphanSource::kRole, {}},
                                                            {FeatureFilter::kRole, {}}, {NarrowPhase::kRole, {}}};
  double bounds = 0;
  for (const StageStatistics& stage : statistics.stages) {
    const auto role = roles.find(stage.role);
    if (role == roles.end()) continue;
    role->second.first += stage.prepare_seconds;
    role->second.second += stage.seconds;
    bounds += stage.bounds_seconds;
  }
  row["bounds_s"] = rounded(bounds);
  for (const auto& [role, seconds] : roles) {
    std::string name = role;
    std::replace(name.begin(), name.end(), '-', '_');
    row[name + "_prepare_s"] = rounded(seconds.first);
    row[name + "_run_s"] = rounded(seconds.second);
  }
  return row;
}

struct Contestant {
  Contestant(const Registry& registry, const Entrant& entrant_)
      : entrant(entrant_), pipeline(registry, entrant.spec), workspace(pipeline.make_workspace()) {}
  const Entrant& entrant;
  Pipeline pipeline;
  Workspace workspace;
};

/// One SceneRun of a plan.
class Runner {
 public:
  Runner(const Registry& registry, const SceneRun& run, int rounds, Executor& executor,
         const std::function<void()>& before_each)
      : run_(run), rounds_(rounds), executor_(executor), before_each_(before_each), reader_(run.file) {
    for (const Entrant& entrant : run.entrants) contestants_.push_back(std::make_unique<Contestant>(registry, entrant));
  }

  std::vector<json> measure(const MotionWindow& window) {
    std::vector<json> rows;
    for (int round = 0; round < rounds_; ++round) {
      if (round == 0 || edits_in(window) || window.count == 1) {
        stepper_.emplace(reader_, run_.config);  // element slots, and counts with them, depend on the way taken
        go_to(std::max(window.first - 1, 0));
        for (const auto& contestant : contestants_) run(*contestant);
      }
      for (int k = window.first; k < window.first + window.count; ++k) {
        go_to(k);
        if (round == 0) remember(k);
        for (std::size_t i = 0; i < contestants_.size(); ++i) {
          Contestant& contestant = *contestants_[(i + static_cast<std::size_t>(round)) % contestants_.size()];
          run(contestant);
          rows.push_back(row(contestant, k, round));
        }
      }
    }
    return rows;
  }

 private:
  /// Whether cells change from the motion before the window to its last one.
  bool edits_in(const MotionWindow& window) {
    for (int step = std::max(window.first, 1); step < window.first + window.count; ++step)
      if (!reader_.same_cells(step, step + 1)) return true;
    return false;
  }

  void go_to(int motion) {
    stepper_->go_to(motion);
    topology_ = &stepper_->topology();
    motion_ = stepper_->motion();
    if (run_.motion_scale != 1) scale(motion_);
    if (run_.subdivisions == 0) return;
    RefinedStep refined = refine(*topology_, motion_, run_.subdivisions,
                                 run_.config.shells == ShellModel::solid ? Division::in_plane : Division::everywhere);
    motion_ = std::move(refined.motion);
    if (!refined_ || stepper_->topology().version() != refined_version_) refined_.emplace(std::move(refined.mesh));
    refined_version_ = stepper_->topology().version();
    topology_ = &*refined_;
  }

  void scale(Motion& motion) const {
    for (Index v = 0; v < motion.vertex_count(); ++v) {
      const Vec3 x0 = motion.point(v, 0);
      motion.set(v, 1, x0 + run_.motion_scale * (motion.point(v, 1) - x0));
    }
  }

  void run(Contestant& contestant) {
    before_each_();
    Request request;
    request.count_adjacent = false;
    request.leave_out_shell_neighbours = run_.config.shells == ShellModel::solid && run_.subdivisions == 0;
    const Step step{*topology_, motion_, everything_};
    contestant.pipeline.run(step, contestant.workspace, executor_, result_, request);
  }

  void remember(int motion) {
    const Mesh& mesh = topology_->mesh();
    of_motion_[motion] = {{"elements", mesh.element_count()},
                          {"vertices", topology_->features().vertex_count()},
                          {"edge_count", topology_->features().edge_count()},
                          {"triangle_count", topology_->features().triangle_count()},
                          {"moved_edges", mean_moved_edges(topology_->features(), motion_)},
                          {"adjacent", adjacent_pair_count(*topology_)}};
  }

  json row(const Contestant& contestant, int motion, int round) {
    json row = run_.columns;
    row.update(columns_of(result_.statistics));
    row.update({{"table", contestant.entrant.table},
                {"scene", run_.scene},
                {"pipeline", contestant.entrant.pipeline},
                {"variant", contestant.entrant.variant},
                {"motion_model", name_of(run_.config.motion)},
                {"edges", name_of(run_.config.edge_set)},
                {"shells", name_of(run_.config.shells)},
                {"motion", motion},
                {"round", round},
                {"threads", executor_.workers()},
                {"topology_seconds", rounded(stepper_->edit_seconds())},
                {"contacts_hash", contacts_hash(result_.contacts)}});
    json& known = of_motion_.at(motion);
    if (!known.contains("touching_pairs")) known["touching_pairs"] = touching_pair_count(*topology_, result_.contacts);
    for (const char* name : {"elements", "vertices", "edge_count", "triangle_count", "moved_edges", "touching_pairs"})
      row[name] = known.at(name);
    // Without an O-Set the broad phase emits adjacent pairs, too (docs/pipelines.md).
    row["adjacent_pairs"] = contestant.entrant.spec.orphans ? json(0) : known.at("adjacent");
    return row;
  }

  const SceneRun& run_;
  const int rounds_;
  Executor& executor_;
  const std::function<void()>& before_each_;
  SequenceReader reader_;
  std::optional<SequenceStepper> stepper_;
  std::vector<std::unique_ptr<Contestant>> contestants_;
  const ObjectFilter everything_;
  const Topology* topology_ = nullptr;
  Motion motion_;
  std::optional<Topology> refined_;
  std::uint64_t refined_version_ = 0;
  StepResult result_;
  std::map<int, json> of_motion_;
};

}  // namespace

void run_experiment(const Registry& registry, const ExperimentPlan& plan, Executor& executor, RecordFile& record,
                    const std::function<void(std::size_t, std::size_t)>& progress) {
  const std::size_t total = measured_runs(plan);
  std::size_t done = 0;
  for (std::size_t r = 0; r < plan.runs.size(); ++r) {
    const SceneRun& run = plan.runs[r];
    std::unique_ptr<Runner> runner;
    const std::function<void()> before_each = [&] {
      if (progress) progress(done, total);
    };
    for (const MotionWindow& window : run.windows) {
      const std::string key = fmt::format("{}/{}/{}", r, run.scene, window.first);
      if (!record.has(key)) {
        if (!runner) runner = std::make_unique<Runner>(registry, run, rounds_of(plan, run), executor, before_each);
        record.add(key, runner->measure(window));
      }
      done +=
          static_cast<std::size_t>(window.count) * run.entrants.size() * static_cast<std::size_t>(rounds_of(plan, run));
    }
  }
}

json provenance(const ExperimentPlan& plan, const Executor& executor) {
  json result = machine_facts();
  result["plan"] = to_json(plan);
  result["setting"] = plan.setting;
  result["rounds"] = plan.rounds;
  result["threads"] = executor.workers();
  result["inputs"] = json::array();
  std::map<std::string, std::string> files;
  for (const SceneRun& run : plan.runs) files.emplace(run.file, run.scene);
  for (const auto& [file, scene] : files)
    result["inputs"].push_back(
        {{"scene", scene}, {"file", std::filesystem::path(file).filename().string()}, {"fnv1a", file_hash(file)}});
  return result;
}

}  // namespace volccd
