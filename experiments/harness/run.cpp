#include <volccd/experiments/harness/run.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/experiments/harness/boundary_shells.hpp>
#include <volccd/experiments/harness/motion_measures.hpp>
#include <volccd/experiments/harness/subdivide.hpp>
#include <volccd/io/stats_json.hpp>
#include <volccd/oracle/cases/instruction_sets.hpp>
#include <volccd/pipelines/step_runner.hpp>

namespace volccd {

using nlohmann::json;

namespace {

/// Rounds seconds to nanoseconds, the resolution of the clock.
double rounded(double seconds) { return std::round(seconds * 1e9) / 1e9; }

json columns_of(const Statistics& statistics) {
  json row = to_json(statistics);
  for (const char* other : {"stages", "steps", "adjacent_pairs", "initial_overlaps", "duplicates"}) row.erase(other);
  row["seconds"] = rounded(statistics.seconds);
  std::map<std::string, std::pair<double, double>> roles = {
      {BroadPhase::kRole, {}}, {ElementCulling::kRole, {}}, {Assignment::kRole, {}}, {OrphanSource::kRole, {}},
      {Flood::kRole, {}},      {FeatureFilter::kRole, {}},  {NarrowPhase::kRole, {}}};
  double bounds = 0;
  for (const StageStatistics& stage : statistics.stages) {
    const auto role = roles.find(stage.role);
    if (role == roles.end()) continue;
    role->second.first += stage.prepare_seconds;
    role->second.second += stage.seconds;
    bounds += stage.counter("bounds_seconds");
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
  const Entrant& entrant;
  StepRunner runner;
  double first_seconds = 0;  ///< time of its first step; 0 before it
};

/// One SceneRun of a plan.
class Runner {
 public:
  Runner(const Registry& registry, const SceneRun& run, Executor& executor, const std::function<void()>& before_each)
      : run_(run),
        own_executor_(run.threads > 0 ? make_executor(run.threads) : nullptr),
        executor_(own_executor_ ? *own_executor_ : executor),
        before_each_(before_each),
        reader_(run.file) {
    for (const Entrant& entrant : run.entrants)
      contestants_.push_back(
          {entrant, StepRunner(Pipeline(registry, entrant.spec),
                               {.executor = &executor_, .leave_out_shell_neighbours = thickened()})});
  }

  /// The rounds [rounds.first, rounds.second) of a window.
  std::vector<json> measure(const StepWindow& window, std::pair<int, int> rounds) {
    std::vector<json> rows;
    for (int round = rounds.first; round < rounds.second; ++round) measure(window, round, rows);
    for (int again = 0; again < kRepeats && replace_stalled(window, rows); ++again) {
    }
    return rows;
  }

 private:
  /// How often a window with stalled rows is measured once more.
  static constexpr int kRepeats = 2;

  void measure(const StepWindow& window, int round, std::vector<json>& rows) {
    stepper_.emplace(reader_, run_.config);  // element slots, and with them counts, depend on the edits before
    boundary_.reset();
    go_to(std::max(window.first - 1, 0));
    for (Contestant& contestant : contestants_) run(contestant);
    for (int k = window.first; k < window.first + window.count; ++k) {
      go_to(k);
      if (!of_step_.contains(k)) remember(k);
      for (std::size_t i = 0; i < contestants_.size(); ++i) {
        Contestant& contestant = contestants_[(i + static_cast<std::size_t>(round)) % contestants_.size()];
        run(contestant);
        rows.push_back(row(contestant, k, round));
        rows.back()["window"] = window.first;
      }
    }
  }

  /// A row is stalled if it took more than three times the fastest of its rounds, and a millisecond more. Measures the
  /// window once more if there is one, and puts the rows of this round, where they are faster, in the place of the
  /// stalled ones, with the time that was replaced. Returns whether there was one.
  bool replace_stalled(const StepWindow& window, std::vector<json>& rows) {
    const auto key = [](const json& row) {
      return json::array({row.at("step"), row.at("table"), row.at("pipeline"), row.at("variant")}).dump();
    };
    std::map<std::string, double> fastest;
    for (const json& row : rows) {
      const double seconds = row.at("seconds");
      double& min = fastest.try_emplace(key(row), seconds).first->second;
      min = std::min(min, seconds);
    }
    const auto stalled = [&](const json& row) {
      return row.at("seconds").get<double>() > 3 * fastest.at(key(row)) + 1e-3;
    };
    if (std::none_of(rows.begin(), rows.end(), stalled)) return false;
    std::vector<json> more;
    measure(window, 0, more);
    std::map<std::string, const json*> of_key;
    for (const json& row : more) of_key[key(row)] = &row;
    for (json& row : rows) {
      const json& other = *of_key.at(key(row));
      if (!stalled(row) || other.at("seconds") >= row.at("seconds")) continue;
      const json round = row.at("round"), replaced = row.at("seconds");
      row = other;
      row["round"] = round;
      row["stalled_seconds"] = replaced;
    }
    return true;
  }

  void go_to(int step) {
    stepper_->go_to(step, executor_);
    topology_ = &stepper_->topology();
    motion_ = stepper_->motion();
    if (run_.motion_scale != 1) motion_ = scaled(motion_, run_.motion_scale);
    if (run_.subdivisions > 0) divide();
    if (std::none_of(run_.entrants.begin(), run_.entrants.end(), [](const Entrant& e) { return e.on_boundary; }))
      return;
    if (!boundary_) boundary_.emplace(thickened() ? 3 : 1);
    boundary_->update(*topology_, motion_);
  }

  /// Whether the mesh has three vertices for each vertex of a shell.
  bool thickened() const { return run_.config.shells == ShellModel::solid && run_.subdivisions == 0; }

  void divide() {
    RefinedStep refined = refine(*topology_, motion_, run_.subdivisions,
                                 run_.config.shells == ShellModel::solid ? Division::in_plane : Division::everywhere);
    motion_ = std::move(refined.motion);
    if (!refined_ || stepper_->topology().version() != refined_version_)
      refined_.emplace(std::move(refined.mesh), executor_);
    refined_version_ = stepper_->topology().version();
    topology_ = &*refined_;
  }

  void run(Contestant& contestant) {
    before_each_();
    const bool on_boundary = contestant.entrant.on_boundary;
    contestant.runner.set_separation(separation_for(contestant.entrant));
    contestant.runner.run(topology(on_boundary), on_boundary ? boundary_->motion() : motion_,
                          {.count_adjacent = false});
    if (contestant.first_seconds == 0) contestant.first_seconds = contestant.runner.result().statistics.seconds;
  }

  double separation_for(const Entrant& entrant) const {
    return entrant.without_separation ? 0 : stepper_->separation();
  }

  const Topology& topology(bool of_boundary) const { return of_boundary ? boundary_->topology() : *topology_; }

  void remember(int step) {
    of_step_[step] = measures(*topology_, motion_);
    if (boundary_) of_boundary_[step] = measures(boundary_->topology(), boundary_->motion());
  }

  static json measures(const Topology& topology, const Motion& motion) {
    const Features& features = topology.features();
    return {{"elements", topology.mesh().element_count()},
            {"vertices", features.vertex_count()},
            {"edge_count", features.edge_count()},
            {"triangle_count", features.triangle_count()},
            {"moved_edges", mean_moved_edges(features, motion)},
            {"adjacent", adjacent_pair_count(topology)}};
  }

  json row(const Contestant& contestant, int step, int round) {
    const bool on_boundary = contestant.entrant.on_boundary;
    const StepResult& result = contestant.runner.result();
    json row = run_.columns;
    row.update(columns_of(result.statistics));
    row.update({{"table", contestant.entrant.table},
                {"scene", run_.scene},
                {"pipeline", contestant.entrant.pipeline},
                {"variant", contestant.entrant.variant},
                {"motion_model", name_of(run_.config.motion)},
                {"edges", name_of(run_.config.edge_set)},
                {"shells", name_of(run_.config.shells)},
                {"mesh", on_boundary ? "boundary" : "whole"},
                {"separation", separation_for(contestant.entrant)},
                {"step", step},
                {"round", round},
                {"threads", executor_.workers()},
                {"topology_seconds", rounded(on_boundary ? boundary_->edit_seconds() : stepper_->edit_seconds())},
                {"first_seconds", rounded(contestant.first_seconds)},
                {"stalled_seconds", 0.0},
                {"contacts_hash", contacts_hash(result.contacts)}});
    json& known = (on_boundary ? of_boundary_ : of_step_).at(step);
    if (!known.contains("touching_pairs"))
      known["touching_pairs"] = touching_pair_count(topology(on_boundary), result.contacts);
    for (const char* name : {"elements", "vertices", "edge_count", "triangle_count", "moved_edges", "touching_pairs"})
      row[name] = known.at(name);
    if (contestant.entrant.without_separation)
      row["touching_pairs"] = touching_pair_count(topology(on_boundary), result.contacts);
    // Without an O-Set the broad phase emits adjacent pairs, too (docs/pipelines.md).
    row["adjacent_pairs"] = contestant.entrant.spec.orphans ? json(0) : known.at("adjacent");
    return row;
  }

  const SceneRun& run_;
  const std::unique_ptr<Executor> own_executor_;
  Executor& executor_;
  const std::function<void()>& before_each_;
  SequenceReader reader_;
  std::optional<SequenceStepper> stepper_;
  std::vector<Contestant> contestants_;
  const Topology* topology_ = nullptr;
  Motion motion_;
  std::optional<Topology> refined_;
  std::uint64_t refined_version_ = 0;
  std::optional<BoundaryShells> boundary_;  ///< if an entrant runs on the boundary
  std::map<int, json> of_step_, of_boundary_;
};

}  // namespace

bool run_experiment(const Registry& registry, const ExperimentPlan& plan, Executor& executor, RecordFile& record,
                    const std::function<void(std::size_t, std::size_t)>& progress) {
  const std::size_t total = measured_runs(plan);
  std::size_t done = 0;
  const std::function<void()> before_each = [&] {
    if (progress) progress(done, total);
  };
  for (int process = 0; process < plan.processes; ++process) {
    bool measured = false;
    for (std::size_t r = 0; r < plan.runs.size(); ++r) {
      const SceneRun& run = plan.runs[r];
      const std::pair<int, int> rounds = rounds_of_process(plan, run, process);
      std::unique_ptr<Runner> runner;
      for (const StepWindow& window : run.windows) {
        const std::string key = fmt::format("{}/{}/{}/{}", r, run.scene, window.first, process);
        if (!record.has(key) && rounds.first < rounds.second) {
          if (!runner) runner = std::make_unique<Runner>(registry, run, executor, before_each);
          std::vector<json> rows = runner->measure(window, rounds);
          for (json& row : rows) row["process"] = process;
          record.add(key, rows);
          measured = true;
        }
        done += static_cast<std::size_t>(window.count) * run.entrants.size() *
                static_cast<std::size_t>(rounds.second - rounds.first);
      }
    }
    if (measured && process + 1 < plan.processes) return false;
  }
  return true;
}

namespace {

/// Whether all stages but the narrow phase keep every contact.
bool keeps_contacts(const Registry& registry, const PipelineSpec& spec) {
  const auto sound = [](const auto& descriptor) { return descriptor.guarantee != Guarantee::approximate; };
  const auto all = [&]<class Stage>(const std::vector<StageChoice>& choices) {
    return std::all_of(choices.begin(), choices.end(),
                       [&](const StageChoice& choice) { return sound(registry.stage<Stage>(choice.name)); });
  };
  return sound(registry.stage<BroadPhase>(spec.broad_phase.name)) &&
         all.template operator()<ElementCulling>(spec.element_culling) &&
         sound(registry.stage<Assignment>(spec.assignment.name)) &&
         (!spec.flood || sound(registry.stage<Flood>(spec.flood->name))) &&
         (!spec.orphans || sound(registry.stage<OrphanSource>(spec.orphans->name))) &&
         all.template operator()<FeatureFilter>(spec.feature_filters);
}

std::string row_key(const json& scene, const json& model, const json& edges, const Entrant& entrant) {
  return json::array({scene, model, edges, entrant.table, entrant.pipeline, entrant.variant}).dump();
}

/// Returns "" if both have the same contacts in every step.
std::string difference(const Entrant& entrant, const std::map<int, const json*>& rows, const Entrant& reference,
                       const std::map<int, const json*>& expected) {
  for (const auto& [step, row] : rows) {
    const json& other = *expected.at(step);
    if (row->at("contacts_hash") == other.at("contacts_hash")) continue;
    const auto found = [](const json& r) {
      return fmt::format("{} (undecided {})", r.at("contacts").get<std::uint64_t>(),
                         r.at("undecided").get<std::uint64_t>());
    };
    return fmt::format("{}, step {}: {} {} found {} contacts, {} {} {}", row->at("scene").get<std::string>(), step,
                       entrant.pipeline, entrant.variant, found(*row), reference.pipeline, reference.variant,
                       found(other));
  }
  return "";
}

}  // namespace

std::vector<std::string> contact_differences(const Registry& registry, const ExperimentPlan& plan,
                                             const std::vector<json>& rows) {
  std::map<std::string, std::map<int, const json*>> by_entrant;
  for (const json& row : rows) {
    Entrant entrant{row.at("table"), row.at("pipeline"), row.at("variant"), {}};
    by_entrant[row_key(row.at("scene"), row.at("motion_model"), row.at("edges"), entrant)][row.at("step")] = &row;
  }
  std::vector<std::string> lines;
  for (const SceneRun& run : plan.runs) {
    const auto rows_of = [&](const Entrant& entrant) {
      return by_entrant.at(row_key(run.scene, name_of(run.config.motion), name_of(run.config.edge_set), entrant));
    };
    std::map<std::string, const Entrant*> references;  // by narrow phase
    for (const Entrant& entrant : run.entrants) {
      if (entrant.on_boundary || entrant.without_separation || !keeps_contacts(registry, entrant.spec)) continue;
      const std::string test = json{entrant.spec.narrow_phase.name, entrant.spec.narrow_phase.options}.dump();
      const auto [reference, is_first] = references.try_emplace(test, &entrant);
      if (is_first) continue;
      const Entrant& first = *reference->second;
      if (const std::string line = difference(entrant, rows_of(entrant), first, rows_of(first)); !line.empty())
        lines.push_back(line);
    }
  }
  return lines;
}

json identity_of(const json& provenance) {
  json identity = json::object();
  for (const char* fact : {"plan", "threads", "commit", "program_fnv1a", "compiler", "flags", "cpu", "inputs"})
    identity[fact] = provenance.at(fact);
  return identity;
}

std::optional<json> complete_record(const std::string& file, const json& identity) {
  if (!std::filesystem::exists(file)) return std::nullopt;
  try {
    json record = read_record(file);
    if (identity_of(record.at("provenance")) == identity) return record;
  } catch (const Error&) {
  } catch (const json::exception&) {
  }
  return std::nullopt;
}

json provenance(const ExperimentPlan& plan, const Executor& executor) {
  json result = machine_facts();
  result["program_fnv1a"] = file_hash("/proc/self/exe");
  result["plan"] = to_json(plan);
  result["isa"] = cases::InstructionSets().name(0);
  result["setting"] = plan.setting;
  if (!plan.options.empty()) result["options"] = plan.options;
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
