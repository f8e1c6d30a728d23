#include <cstdio>

#include <fmt/format.h>

#include <volccd/experiments/scenes/scene.hpp>
#include <volccd/experiments/scenes/sequences.hpp>
#include <volccd/program/commands.hpp>

namespace volccd {

namespace {

int list_scenes() {
  fmt::print("simulated\n");
  for (const SimulatedScene& scene : simulated_scenes()) {
    fmt::print("  {:<20} {}\n", scene.name, scene.description);
    fmt::print("  {:<20}   --elements {} (about; --quick: {}) --steps {} --seed 1\n", "", scene.default_elements,
               scene.quick_elements, scene.frames);
  }
  fmt::print("computed\n");
  for (const SceneDescriptor& scene : scenes()) {
    fmt::print("  {:<20} {}{}\n", scene.name, scene.description, scene.needs_mesh ? " (--mesh FILE)" : "");
    for (const OptionInfo& option : scene.options)
      fmt::print("  {:<20}   --{:<10} {} ({}; default {})\n", "", option.name, option.description, option.allowed,
                 option.default_value.empty() ? "by itself" : option.default_value);
  }
  const std::vector<ExternalScene> external = external_scenes();
  if (!external.empty()) fmt::print("of other programs\n");
  for (const ExternalScene& scene : external) fmt::print("  {:<20} {}\n", scene.name, scene.description);
  fmt::print(
      "\nA name goes wherever a sequence file goes (`volccd info octopi`, or octopi-quick); simulated ones are "
      "computed once.\n");
  return kDone;
}

}  // namespace

void add_scene_command(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("scene", "made-up sequences: list them, generate one, draw pictures");
  command->require_subcommand(1);
  CLI::App* list_command = command->add_subcommand("list", "the scenes and their options");
  list_command->callback([&action] { action = list_scenes; });
  add_generate_command(*command, action);
  add_picture_command(*command, action);
}

}  // namespace volccd
