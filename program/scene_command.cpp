#include <cstdio>
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <volccd/experiments/scenes/scene.hpp>
#include <volccd/experiments/scenes/sequences.hpp>
#include <volccd/program/commands.hpp>
#include <volccd/program/report.hpp>

namespace volccd {

namespace {

constexpr std::size_t kIndentation = 23;

nlohmann::json scene_json(const std::string& name, const char* kind, const std::string& description) {
  return {{"name", name}, {"kind", kind}, {"description", description}, {"options", nlohmann::json::array()}};
}

void add_simulated(const Report& report, nlohmann::json& list) {
  report.print("simulated\n");
  for (const SimulatedScene& scene : simulated_scenes()) {
    report.print("{}", labelled("  " + scene.name, scene.description, kIndentation));
    report.print("{}", labelled("",
                                fmt::format("--elements {} (about; --quick: {}) --frames {} --seed 1",
                                            scene.default_elements, scene.quick_elements, scene.frames),
                                kIndentation + 2));
    nlohmann::json entry = scene_json(scene.name, "simulated", scene.description);
    entry["elements"] = scene.default_elements;
    entry["quick_elements"] = scene.quick_elements;
    entry["frames"] = scene.frames;
    list.push_back(std::move(entry));
  }
}

void add_computed(const Report& report, nlohmann::json& list) {
  report.print("computed\n");
  for (const SceneDescriptor& scene : scenes()) {
    report.print("{}", labelled("  " + scene.name, scene.description + (scene.needs_mesh ? " (--mesh FILE)" : ""),
                                kIndentation));
    for (const OptionInfo& option : scene.options)
      report.print("{}", labelled(std::string(kIndentation + 2, ' ') + "--" + option.name,
                                  fmt::format("{} ({}; default {})", option.description, option.allowed,
                                              option.default_value.empty() ? "by itself" : option.default_value),
                                  kIndentation + 15));
    nlohmann::json entry = scene_json(scene.name, "computed", scene.description);
    entry["options"] = options_json(scene.options);
    entry["needs_mesh"] = scene.needs_mesh;
    list.push_back(std::move(entry));
  }
}

int list_scenes(const ReportOptions& options) {
  const Report report(options);
  nlohmann::json list = nlohmann::json::array();
  add_simulated(report, list);
  add_computed(report, list);
  const std::vector<ExternalScene> external = external_scenes();
  if (!external.empty()) report.print("of other programs\n");
  for (const ExternalScene& scene : external) {
    report.print("{}", labelled("  " + scene.name, scene.description, kIndentation));
    list.push_back(scene_json(scene.name, "external", scene.description));
  }
  report.print("\n{}\n", wrapped("A name can stand in the place of any sequence file (`volccd detect octopi`, or "
                                 "octopi-quick, octopi-seed-2, octopi-quick-seed-2); "
                                 "simulated ones are computed once."));
  report.write("scene list", {{"scenes", list}});
  return kDone;
}

}  // namespace

void add_scene_command(CLI::App& app, Action& action) {
  CLI::App* command =
      app.add_subcommand("scene", "scenes: list them, generate one; pictures and export of single frames of any");
  command->require_subcommand(1);
  CLI::App* list_command = command->add_subcommand("list", "the scenes and their options");
  const auto options = std::make_shared<ReportOptions>();
  options->add_to(*list_command);
  list_command->callback([options, &action] { action = [options] { return list_scenes(*options); }; });
  add_generate_command(*command, action);
  add_picture_command(*command, action);
  add_export_command(*command, action);
}

}  // namespace volccd
