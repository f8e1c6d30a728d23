#include <algorithm>
#include <cstdio>
#include <map>

#include <fmt/format.h>

#include <volccd/experiments/program/commands.hpp>
#include <volccd/experiments/scenes/scene.hpp>

namespace volccd {

namespace {

int list() {
  for (const SceneDescriptor& scene : scenes()) {
    fmt::print("{:<10} {}{}\n", scene.name, scene.description, scene.needs_mesh ? " (--mesh FILE)" : "");
    for (const OptionInfo& option : scene.options)
      fmt::print("  --{:<10} {} ({}; default {})\n", option.name, option.description, option.allowed,
                 option.default_value.empty() ? "by itself" : option.default_value);
  }
  return kDone;
}

struct GenerateOptions {
  std::string name, output, mesh;
  int mesh_step = 0;
  std::map<std::string, std::string> values;  ///< by option; empty: not given
};

int generate(const GenerateOptions& options) {
  OptionValues values;
  for (const auto& [name, value] : options.values)
    if (!value.empty()) values[name] = value;
  std::unique_ptr<Scene> scene;
  if (options.mesh.empty()) {
    scene = make_scene(options.name, values);
  } else {
    const Shape mesh = shape_from_file(options.mesh, options.mesh_step);
    scene = make_scene(options.name, values, &mesh);
  }
  write_scene(*scene, options.output);
  SequenceCells cells;
  scene->cells(0, cells);
  fmt::print("{}: {} frames, {} elements at first, {} vertices, written to {}\n", options.name, scene->frames(),
             cells.size(), scene->vertex_count(), options.output);
  return kDone;
}

/// Options of all scenes, each once.
std::map<std::string, std::string> option_texts() {
  std::map<std::string, std::string> texts;
  for (const SceneDescriptor& scene : scenes())
    for (const OptionInfo& option : scene.options) {
      std::string& text = texts[option.name];
      text += (text.empty() ? "" : "; ") + scene.name + ": " + option.description;
    }
  return texts;
}

void add_generate(CLI::App& scene, Action& action) {
  CLI::App* command = scene.add_subcommand("generate", "compute a scene and write it as a sequence");
  const auto options = std::make_shared<GenerateOptions>();
  command->add_option("NAME", options->name, "see `volccd scene list`")->required()->type_name("");
  command->add_option("-o,--output", options->output, "sequence to write (VTKHDF)")->required()->type_name("FILE");
  command->add_option("--mesh", options->mesh, "mesh to work on: a sequence file")->type_name("FILE");
  command->add_option("--mesh-step", options->mesh_step, "step of that file")->capture_default_str();
  for (const auto& [name, text] : option_texts())
    command->add_option("--" + name, options->values[name], text)->type_name("VALUE");
  command->footer(
      "Examples:\n"
      "  volccd scene generate builtin -o run.vtkhdf\n"
      "  volccd scene generate deform --mesh octopus.vtkhdf --motion twist,collide --copies 3 -o octopi.vtkhdf\n"
      "  volccd scene generate deform --mesh octopus.vtkhdf --motion twist --amount 10 --steps 5 -o twist.vtkhdf");
  command->callback([options, &action] { action = [options] { return generate(*options); }; });
}

}  // namespace

void add_scene_command(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("scene", "made-up sequences: list them, generate one");
  command->require_subcommand(1);
  CLI::App* list_command = command->add_subcommand("list", "the scenes and their options");
  list_command->callback([&action] { action = list; });
  add_generate(*command, action);
}

}  // namespace volccd
