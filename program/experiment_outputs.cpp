#include <volccd/program/experiment_outputs.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <system_error>

#include <fmt/format.h>

#include <volccd/experiments/scenes/simulated/bake.hpp>
#include <volccd/program/output_plan.hpp>

namespace volccd {

namespace {

/// Whether the file is a record of a run with --full. A file that cannot be read is none.
bool is_full_record(const std::string& file) {
  const nlohmann::json record = nlohmann::json::parse(std::ifstream(file), nullptr, false);
  if (record.is_object()) return record.value("/provenance/setting"_json_pointer, "") == "full";
  if (!record.is_array()) return false;
  return std::any_of(record.begin(), record.end(), [](const nlohmann::json& scene) {  // of `scenes`
    if (!scene.is_object()) return false;
    const SimulatedScene* known = find_simulated_scene(scene.value("scene", ""));
    return known && scene.value("/simulation/elements"_json_pointer, 0) > known->quick_elements;
  });
}

bool is_record_of_own_scenes(const nlohmann::json& record) {
  return record.is_object() && record.value("/provenance/options"_json_pointer, "").find("--scenes") == 0;
}

}  // namespace

void make_folder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw InputError(folder, "", "cannot be created as the folder for records: " + error.message());
}

std::string record_file(const ExperimentOptions& options, const std::string& name, const char* suffix) {
  return (std::filesystem::path(options.output) / (name + suffix)).string();
}

void check_outputs(const ExperimentOptions& options, const std::string& name, const ExperimentPlan& experiment) {
  OutputPlan plan;
  for (const SceneRun& run : experiment.runs) plan.input("the sequence", run.file);
  for (const char* suffix :
       {".json", ".txt", ".incomplete.json", ".incomplete.txt", ".incomplete.jsonl", ".incomplete.old.jsonl"})
    plan.output("-o", record_file(options, name, suffix));
  plan.check();
}

void protect_other_record(const ExperimentOptions& options, const std::string& name) {
  const bool full = name == kScenesExperiment ? !options.quick : options.full;
  const std::string file = record_file(options, name, ".json");
  if (std::filesystem::exists(file) &&
      is_record_of_own_scenes(nlohmann::json::parse(std::ifstream(file), nullptr, false)) == options.scenes.empty())
    throw ConfigError(fmt::format("-o {}: {} is the record of {}; give another folder, or remove the file",
                                  options.output, file,
                                  options.scenes.empty() ? "a run with --scenes" : "the experiment's own scenes"));
  if (full || !is_full_record(file)) return;
  throw ConfigError(
      fmt::format("-o {}: {} is the record of a full run, which a quick run does not replace; give another "
                  "folder, or remove the file",
                  options.output, file));
}

void add_finished(const std::string& name, const std::string& record, bool complete, const std::string& text,
                  Finished& finished) {
  finished.push_back({{"experiment", name}, {"record", record}, {"complete", complete}, {"text", text}});
}

}  // namespace volccd
