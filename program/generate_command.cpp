#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <map>

#include <fmt/format.h>

#include <volccd/core/suggest.hpp>
#include <volccd/experiments/scenes/scene.hpp>
#include <volccd/experiments/scenes/sequences.hpp>
#include <volccd/experiments/tables/scene_table.hpp>
#include <volccd/io/output_file.hpp>
#include <volccd/io/sequence/writer.hpp>
#include <volccd/io/stats_json.hpp>
#include <volccd/program/commands.hpp>
#include <volccd/program/output_plan.hpp>
#include <volccd/program/query_options.hpp>
#include <volccd/program/report.hpp>
#include <volccd/program/scene_files.hpp>
#include <volccd/program/step_loop.hpp>

namespace volccd {

namespace {

struct GenerateOptions {
  std::string name, output, mesh, stats;
  int mesh_frame = 0;
  bool quick = false;
  unsigned threads = 0;
  ReportOptions report;
  std::map<std::string, std::string> values;  ///< by option; empty if not given

  /// The options that were given.
  OptionValues given() const {
    OptionValues result;
    for (const auto& [option, value] : values)
      if (!value.empty()) result[option] = value;
    return result;
  }
};

template <typename T>
T option_number(const OptionValues& values, const std::string& option, T fallback) {
  const auto found = values.find(option);
  if (found == values.end()) return fallback;
  const std::string& text = found->second;
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !(value > T{}))
    throw ConfigError(fmt::format("--{}: '{}' is not a positive number", option, text));
  return value;
}

void refuse_other_options(const GenerateOptions& options, const OptionValues& values,
                          std::initializer_list<const char*> known) {
  for (const auto& [option, value] : values)
    if (std::find(known.begin(), known.end(), option) == known.end())
      throw ConfigError(fmt::format("scene {} has no option --{}{}", options.name, option,
                                    did_you_mean(option, std::vector<std::string>(known.begin(), known.end()))));
  if (!options.mesh.empty()) throw ConfigError(fmt::format("scene {} takes no mesh", options.name));
}

/// Throws, before anything is computed, if an output is also an input or cannot be written. `source`: the file that is
/// copied, or empty.
void check_outputs(const GenerateOptions& options, const std::string& source) {
  OutputPlan plan;
  plan.input("--mesh", options.mesh);
  plan.input(options.name, source);
  plan.output("-o", options.output, kSequenceIsNoStream);
  plan.output("--stats", options.stats);
  plan.check();
}

Report report_of(const GenerateOptions& options) {
  return Report(options.report, is_standard_output(options.stats) ? stderr : stdout);
}

void write_stats(const GenerateOptions& options, const std::string& bake_record) {
  if (options.stats.empty()) return;
  const InterruptGuard guard;
  OutputFile file(options.stats);
  file.write(record_with_progress(options.name, options.output, bake_record, options.threads, scene_record).dump(1) +
             "\n");
  file.commit();
}

void print_generated(const GenerateOptions& options) {
  SequenceReader reader(options.output);
  report_of(options).print("{}: {} frames, {} elements at first, {} at last, {} vertices, written to {}\n",
                           options.name, reader.frame_count(), reader.cell_count(0),
                           reader.cell_count(reader.frame_count() - 1), reader.point_count(), options.output);
}

int generate_simulated(const GenerateOptions& options, const SimulatedScene& scene) {
  const OptionValues values = options.given();
  refuse_other_options(options, values, {"elements", "frames", "seed"});
  if (options.quick && values.contains("elements")) throw ConfigError("--quick and --elements exclude each other");
  BakeSettings settings;
  settings.elements = option_number(values, "elements", options.quick ? scene.quick_elements : 0);
  settings.frames = option_number(values, "frames", 0);
  settings.seed = option_number<std::uint64_t>(values, "seed", 1);
  check_outputs(options, baked_file(scene, settings));
  {
    const auto executor = make_executor(options.threads);
    BakeProgress progress(scene.name);
    const std::optional<std::string> file = bake(scene, settings, *executor, progress.hooks());
    if (!file) throw Interrupted(scene.name + ": stopped; the same command continues after the last complete frame");
    copy_file_whole(*file, options.output);
  }
  print_generated(options);
  write_stats(options, bake_record_file(scene, settings));
  return kDone;
}

int generate_external(const GenerateOptions& options, const ExternalScene& scene) {
  refuse_other_options(options, options.given(), {});
  if (options.quick) throw ConfigError(fmt::format("scene {} has one size", scene.name));
  check_outputs(options, external_scene_file(scene));
  copy_file_whole(external_scene_file(scene), options.output);
  print_generated(options);
  write_stats(options, "");
  return kDone;
}

int generate_computed(const GenerateOptions& options) {
  if (options.quick) throw ConfigError(fmt::format("scene {} has no quick size: use --elements", options.name));
  std::unique_ptr<Scene> scene;
  if (options.mesh.empty()) {
    check_outputs(options, "");
    scene = make_scene(options.name, options.given());
  } else {
    const std::string file = sequence_file(options.mesh, options.threads);
    check_outputs(options, file);
    const Shape mesh = shape_from_file(file, options.mesh_frame);
    scene = make_scene(options.name, options.given(), &mesh);
  }
  const InterruptGuard guard;
  StepsDone steps;
  {
    Progress progress("computing " + options.name, static_cast<std::size_t>(scene->frames()), "frames");
    steps = write_scene(*scene, options.output, [&](int done) {
      progress.advance(static_cast<std::size_t>(done));
      return !InterruptGuard::interrupted();
    });
  }
  if (steps.done == 0) throw Interrupted("interrupted before the first frame was complete: nothing has been written");
  print_generated(options);
  if (!steps.complete()) {
    print_incomplete(steps, report_of(options).people());
    return exit_code(steps);
  }
  write_stats(options, "");
  return kDone;
}

int generate_scene(const GenerateOptions& options) {
  if (const SimulatedScene* scene = find_simulated_scene(options.name)) return generate_simulated(options, *scene);
  std::string known;
  for (const SimulatedScene& scene : simulated_scenes()) known += scene.name + ", ";
  for (const ExternalScene& scene : external_scenes()) {
    if (scene.name == options.name) return generate_external(options, scene);
    known += scene.name + ", ";
  }
  for (const SceneDescriptor& scene : scenes()) {
    if (scene.name == options.name) return generate_computed(options);
    known += scene.name + ", ";
  }
  throw ConfigError(fmt::format("no scene is called \"{}\"; there are: {}{}", options.name,
                                known.substr(0, known.size() - 2), did_you_mean(options.name, known)));
}

/// Options of all scenes, each once.
std::map<std::string, std::string> option_texts() {
  std::map<std::string, std::string> texts;
  for (const SceneDescriptor& scene : scenes())
    for (const OptionInfo& option : scene.options) {
      std::string& text = texts[option.name];
      text += (text.empty() ? "" : "; ") + scene.name + ": " + option.description;
    }
  texts["elements"] += "; simulated scenes: about";
  texts["frames"] += "; simulated scenes: frames";
  texts["seed"] += "; simulated scenes: for what is random in them";
  return texts;
}

}  // namespace

void add_generate_command(CLI::App& scene, Action& action) {
  CLI::App* command = scene.add_subcommand("generate", "compute a scene and write it as a sequence");
  const auto options = std::make_shared<GenerateOptions>();
  command->add_option("NAME", options->name, "see `volccd scene list`")->required()->type_name("");
  command->add_option("-o,--output", options->output, "sequence to write (VTKHDF)")->required()->type_name("FILE");
  command->add_option("--stats", options->stats, "write sizes, motion, contacts, edits and energy per frame as JSON")
      ->type_name("FILE");
  command->add_flag("--quick", options->quick, "the small size of a simulated scene");
  add_threads_option(*command, options->threads);
  command->add_option("--mesh", options->mesh, "mesh to work on: a sequence file, or the name of a scene")
      ->type_name("FILE");
  command->add_option("--mesh-frame", options->mesh_frame, "frame of that file")->capture_default_str();
  for (const auto& [name, text] : option_texts())
    command->add_option("--" + name, options->values[name], text)->type_name("VALUE");
  options->report.add_quiet_to(*command);
  command->footer(
      "Simulated scenes are kept in a cache, the folder VOLCCD_CACHE, $XDG_CACHE_HOME/volccd or ~/.cache/volccd: the "
      "second time they are copied from there. After Ctrl-C, the same command continues after the last complete "
      "frame.\n"
      "Examples:\n"
      "  volccd scene generate octopi -o octopi.vtkhdf --stats octopi.json\n"
      "  volccd scene generate crash --quick -o crash.vtkhdf\n"
      "  volccd scene generate builtin -o run.vtkhdf\n"
      "  volccd scene generate deform --mesh octopus.vtkhdf --motion twist,collide --copies 3 -o octopi.vtkhdf\n"
      "  volccd scene generate deform --mesh octopus.vtkhdf --motion twist --amount 10 --frames 5 -o twist.vtkhdf");
  command->callback([options, &action] { action = [options] { return generate_scene(*options); }; });
}

}  // namespace volccd
