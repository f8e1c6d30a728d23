#include <volccd/program/experiment_scenes.hpp>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <volccd/experiments/scenes/simulated/bake.hpp>
#include <volccd/experiments/tables/scene_table.hpp>
#include <volccd/io/output_file.hpp>
#include <volccd/program/progress.hpp>
#include <volccd/program/scene_files.hpp>

namespace volccd {

namespace {

/// Prints the tables, and writes them and the record. An incomplete record never replaces a complete one of another
/// run.
void write_record(const ExperimentOptions& options, const std::string& name, const nlohmann::json& record,
                  const std::string& tables, bool complete, Finished& finished) {
  const Report report(options.report);
  const std::string file = record_file(options, name, complete ? ".json" : ".incomplete.json");
  report.print("{}\n", tables);  // first, so that they are seen even if the disk is full
  write_text_file(file, record.dump(complete && record.is_array() ? 1 : 2) + "\n");
  write_text_file(record_file(options, name, complete ? ".txt" : ".incomplete.txt"), tables);
  report.print("record: {}\n", file);
  add_finished(name, file, complete, tables, finished);
}

struct Baked {
  std::string file, record;
};

/// Bakes the scene unless it is in the cache.
Baked bake_for(const ExperimentOptions& options, const SimulatedScene& scene, Executor& executor) {
  BakeSettings settings;
  settings.elements = options.quick ? scene.quick_elements : 0;
  BakeProgress progress(scene.name);
  const std::optional<std::string> file = bake(scene, settings, executor, progress.hooks());
  if (!file) throw Interrupted(scene.name + ": stopped; the same command goes on from the last whole frame");
  return {*file, bake_record_file(scene, settings)};
}

}  // namespace

int run_scenes(const ExperimentOptions& options, Finished& finished) {
  const std::string name = kScenesExperiment;
  const InterruptGuard guard;
  make_folder(options.output);
  check_outputs(options, name);
  const auto executor = make_executor(options.simulation_threads());
  std::vector<nlohmann::json> records;
  std::string stopped_by;
  int code = kDone;
  const auto stop = [&](const Error& error, int exit) {
    if (records.empty()) throw;
    stopped_by = error.what();
    code = exit;
  };
  try {
    for (const SimulatedScene& scene : simulated_scenes()) {
      if (!scene.variant_of.empty()) continue;
      const Baked baked = bake_for(options, scene, *executor);
      records.push_back(
          record_with_progress(scene.name, baked.file, baked.record, options.simulation_threads(), scene_record));
    }
  } catch (const Interrupted& error) {
    stop(error, kInterrupted);
  } catch (const Error& error) {
    stop(error, kBadInput);
  }
  if (code == kDone) {
    write_record(options, name, records, untitled_text(scene_table(records)), true, finished);
    return kDone;
  }
  const std::string text = fmt::format("{} complete; {}", counted(records.size(), "scene"), stopped_by);
  write_record(options, name, {{"complete", false}, {"stopped_by", stopped_by}, {"records", records}},
               fmt::format("incomplete: {}\n\n{}", text, untitled_text(scene_table(records))), false, finished);
  fmt::print(stderr, "volccd: incomplete: {}\n", text);
  return code;
}

}  // namespace volccd
