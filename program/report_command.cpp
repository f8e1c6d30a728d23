#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include <volccd/experiments/harness/motion_measures.hpp>
#include <volccd/experiments/scenes/sequences.hpp>
#include <volccd/experiments/scenes/shared_data.hpp>
#include <volccd/experiments/scenes/simulated/bake.hpp>
#include <volccd/experiments/tables/text_table.hpp>
#include <volccd/io/sequence/reader.hpp>
#include <volccd/io/stats_json.hpp>
#include <volccd/program/commands.hpp>
#include <volccd/program/progress.hpp>
#include <volccd/program/query_options.hpp>
#include <volccd/program/report.hpp>
#include <volccd/program/scene_files.hpp>
#include <volccd/report/page_files.hpp>
#include <volccd/report/record_data.hpp>
#include <volccd/report/scene_export.hpp>

namespace volccd {

namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr int kReportSchema = 1;

struct PageOptions {
  std::string input, output, pipeline = "VolCCD+", scenes;
  std::vector<std::string> settings;
  double megabytes = 18;
  bool no_contacts = false;
  unsigned threads = 0;
  ReportOptions report;
};

std::optional<PipelineSpec> pipeline_of(const PageOptions& options, const Registry& registry) {
  if (options.no_contacts) return std::nullopt;
  return registry.pipeline(options.pipeline, options.settings);
}

/// Exports one sequence, with progress.
ExportedScene export_with_progress(const std::string& name, const std::string& file, const Registry& registry,
                                   const PageOptions& options, std::size_t max_bytes, Executor& executor) {
  SceneExportConfig config;
  config.pipeline = pipeline_of(options, registry);
  config.max_bytes = max_bytes;
  std::unique_ptr<Progress> shown;
  InterruptGuard::check();
  return export_scene(name, file, registry, config, executor, [&](std::size_t done, std::size_t total) {
    if (!shown) shown = std::make_unique<Progress>(name + ": finding contacts", total, "steps");
    shown->advance(done);
    InterruptGuard::check();
  });
}

/// Path of a sequence that a record names, in the cache of baked scenes or in the shared data. Nothing is computed.
std::optional<std::string> present_file(const std::string& file) {
  for (const std::string& path : {(fs::path(bake_cache_folder()) / file).string(), shared_data_path(file)})
    if (fs::is_regular_file(path)) return path;
  return std::nullopt;
}

/// The command that generates the sequence, or the folder for it.
std::string how_to_get(const RecordedInput& input) {
  for (const std::string& name : {input.scene, input.scene + "-quick"})
    if (const auto file = file_to_simulate(name); file && fs::path(*file).filename() == input.file)
      return simulating_command(name);
  if (is_deformed_scene(input.scene))
    return fmt::format("volccd experiment run {}", input.records.empty() ? "plus" : input.records.front());
  if (file_to_simulate(input.scene))
    return fmt::format("volccd experiment run {} (the record is of another version of the scene)",
                       input.records.empty() ? "all" : input.records.front());
  return fmt::format("put {} into the folder that VOLCCD_DATA names ({})", input.file, shared_data_path(""));
}

bool is_wanted(const PageOptions& options, const RecordedInput& input) {
  if (options.scenes.empty()) return true;
  const std::string list = "," + options.scenes + ",";
  return list.find("," + input.scene + ",") != std::string::npos;
}

/// Exports the scenes of the records, smallest file first, so that large scenes can use what small ones leave of their
/// shares of the size. Shares are proportional to the square roots of the files' sizes.
class SceneList {
 public:
  SceneList(const PageOptions& options, const Registry& registry, ReportFolder& folder)
      : options_(options),
        registry_(registry),
        folder_(folder),
        executor_(make_interruptible_executor(options.threads)) {}

  json add_all(const std::vector<RecordedInput>& inputs, std::size_t bytes) {
    std::vector<std::pair<std::uintmax_t, const RecordedInput*>> present;
    for (const RecordedInput& input : inputs) {
      if (!is_wanted(options_, input)) continue;
      if (const auto file = present_file(input.file))
        present.emplace_back(fs::file_size(*file), &input);
      else
        add_missing(input);
    }
    std::sort(present.begin(), present.end());
    double weights = 0;
    for (const auto& [size, input] : present) weights += std::sqrt(static_cast<double>(size));
    for (const auto& [size, input] : present) {
      const double weight = std::sqrt(static_cast<double>(size));
      bytes -= std::min(bytes, add(*input, static_cast<std::size_t>(static_cast<double>(bytes) * weight / weights)));
      weights -= weight;
    }
    return std::move(list_);
  }

 private:
  std::size_t add(const RecordedInput& input, std::size_t max_bytes) {
    const std::string file = *present_file(input.file), name = fs::path(file).stem().string();
    ExportedScene scene = export_with_progress(name, file, registry_, options_, max_bytes, *executor_);
    json entry = std::move(scene.summary);
    if (!input.fnv1a.empty() && entry.at("fnv1a") != input.fnv1a)
      entry["notes"].push_back("The hash of the file differs from that of the measured file.");
    entry["scene"] = input.scene;
    entry["records"] = input.records;
    add_picture(entry);
    entry["data"] = folder_.write_scene(name, scene.script);
    Report(options_.report).print("{}: {} frames, {}\n", name, entry.at("frames").dump(), memory(scene.script.size()));
    list_.push_back(std::move(entry));
    return scene.script.size();
  }

  void add_missing(const RecordedInput& input) {
    const std::string command = how_to_get(input);
    Report(options_.report)
        .print("{}: not shown, because its file is not there:\n  {}\n  {}\n", input.scene, input.file, command);
    list_.push_back({{"scene", input.scene},
                     {"name", fs::path(input.file).stem().string()},
                     {"file", input.file},
                     {"records", input.records},
                     {"missing", command}});
    add_picture(list_.back());
  }

  /// The picture of the scene beside the records, if there is one.
  void add_picture(json& entry) {
    const std::string scene = entry.at("scene");
    if (fs::path(scene).filename() != scene) return;  // a path, as a record of somebody's own files may have
    const fs::path file = fs::path(options_.input) / "pictures" / (scene + ".png");
    if (fs::is_regular_file(file)) entry["picture"] = folder_.copy_picture(scene, file.string());
  }

  const PageOptions& options_;
  const Registry& registry_;
  ReportFolder& folder_;
  std::unique_ptr<Executor> executor_;
  json list_ = json::array();
};

void finish(ReportFolder& folder, const PageOptions& options, json report) {
  report["schema"] = kReportSchema;
  report["made"] = machine_facts();
  const std::size_t bytes = folder.finish(report);
  Report(options.report)
      .print("{} ({}) written; open it in a browser\n", (fs::path(options.output) / "index.html").string(),
             memory(bytes));
}

int write_report(const PageOptions& options, const Registry& registry) {
  const InterruptGuard guard;
  pipeline_of(options, registry);  // an unknown pipeline is an error before anything is written
  const auto [records, points] = data_of_records(options.input);
  const std::vector<RecordedInput> inputs = inputs_of(records);
  ReportFolder folder(options.output);
  const std::size_t text = records.dump().size() + points.dump().size() + 1'000'000,
                    all = static_cast<std::size_t>(options.megabytes * 1e6);
  json scenes = json::array();
  if (options.scenes != "none")
    scenes = SceneList(options, registry, folder).add_all(inputs, all > text ? all - text : 0);
  finish(folder, options, {{"folder", options.input}, {"records", records}, {"points", points}, {"scenes", scenes}});
  return kDone;
}

int write_view(const PageOptions& options, const Registry& registry) {
  const InterruptGuard guard;
  pipeline_of(options, registry);
  const std::string file = sequence_file(options.input, options.threads);
  warn_of_incomplete(SequenceReader(file));
  ReportFolder folder(options.output);
  const std::string name = fs::path(file).stem().string();
  const auto executor = make_interruptible_executor(options.threads);
  ExportedScene scene =
      export_with_progress(name, file, registry, options, static_cast<std::size_t>(options.megabytes * 1e6), *executor);
  json entry = std::move(scene.summary);
  entry["scene"] = name;
  entry["records"] = json::array();
  entry["data"] = folder.write_scene(name, scene.script);
  for (const json& note : entry.at("notes")) Report(options.report).print("{}\n", note.get<std::string>());
  finish(folder, options,
         {{"folder", ""}, {"records", json::array()}, {"points", nullptr}, {"scenes", json::array({entry})}});
  return kDone;
}

void add_common(CLI::App& command, PageOptions& options) {
  command
      .add_option("-o,--output", options.output, "folder to write: a new or empty one, or one with an earlier report")
      ->required()
      ->type_name("FOLDER");
  command
      .add_option("--pipeline", options.pipeline,
                  "pipeline that computes the contacts and counts of the scenes; see `volccd stages`")
      ->type_name("NAME")
      ->capture_default_str();
  command.add_option("--set", options.settings, "stage.option=value, or role=stage[,stage...]; may be repeated")
      ->type_name("X=Y")
      ->allow_extra_args(false);
  command.add_flag("--no-contacts", options.no_contacts, "show the motion alone, without detection");
  command
      .add_option("--size", options.megabytes,
                  "approximate size in megabytes: larger sequences get coarser positions, then fewer frames, and the "
                  "page says so")
      ->check(CLI::Range(0.1, 2000.0))
      ->type_name("MB")
      ->capture_default_str();
  add_threads_option(command, options.threads, "for detection; ");
  options.report.add_quiet_to(command);
}

}  // namespace

void add_report_command(CLI::App& app, const Registry& registry, Action& action) {
  CLI::App* command =
      app.add_subcommand("report", "tables, figures and scenes of a folder of records, as a page for a browser");
  const auto options = std::make_shared<PageOptions>();
  command->add_option("RESULTS", options->input, "folder with the records of `volccd experiment run`")
      ->required()
      ->type_name("");
  add_common(*command, *options);
  command->add_option("--scenes", options->scenes, "show only these scenes, NAME[,NAME...], or none; default: all")
      ->type_name("LIST");
  command->footer(
      "FOLDER/index.html opens from disk, without a server or a network. The sequences that the records name are\n"
      "shown where they are in the cache or among the shared data; nothing is simulated, and those that are missing\n"
      "are listed with the command that makes them. RESULTS/pictures/SCENE.png is shown beside the name of a scene.\n"
      "Examples:\n"
      "  volccd report results/ -o report/\n"
      "  volccd report results/ --scenes liver,octopi -o report/\n"
      "  volccd report build/tables --scenes none -o report/");
  command->callback(
      [options, &registry, &action] { action = [options, &registry] { return write_report(*options, registry); }; });
}

void add_view_command(CLI::App& app, const Registry& registry, Action& action) {
  CLI::App* command = app.add_subcommand("view", "one sequence with its contacts in 3-D, as a page for a browser");
  const auto options = std::make_shared<PageOptions>();
  options->megabytes = 40;
  command->add_option("FILE", options->input, "sequence (VTKHDF), or the name of a scene")->required()->type_name("");
  add_common(*command, *options);
  command->footer(
      "FOLDER/index.html opens from disk, without a server or a network.\n"
      "Examples:\n"
      "  volccd view run.vtkhdf -o view/\n"
      "  volccd view crash.vtkhdf --pipeline VolCCD --size 80 -o view/\n"
      "  volccd view run.vtkhdf --no-contacts -o view/");
  command->callback(
      [options, &registry, &action] { action = [options, &registry] { return write_view(*options, registry); }; });
}

}  // namespace volccd
