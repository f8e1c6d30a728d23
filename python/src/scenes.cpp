// Scenes by name.
#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/core/suggest.hpp>
#include <volccd/experiments/scenes/scene.hpp>
#include <volccd/experiments/scenes/sequences.hpp>

#include "bind.hpp"
#include "signals.hpp"

namespace volccd::python {

namespace {

/// The simulated scene of this name, which may end with "-quick".
const SimulatedScene* simulated(const std::string& name, BakeSettings& settings) {
  constexpr std::string_view quick = "-quick";
  if (const SimulatedScene* scene = find_simulated_scene(name)) return scene;
  if (!name.ends_with(quick)) return nullptr;
  const SimulatedScene* scene = find_simulated_scene(name.substr(0, name.size() - quick.size()));
  if (scene) settings.elements = scene->quick_elements;
  return scene;
}

/// All names that scene_file() accepts, with a description of one line.
py::dict scene_names() {
  py::dict names;
  for (const ExternalScene& scene : external_scenes()) names[py::str(scene.name)] = scene.description;
  for (const SimulatedScene& scene : simulated_scenes()) {
    names[py::str(scene.name)] = scene.description;
    names[py::str(scene.name + "-quick")] = scene.description + " (small)";
  }
  for (const SceneDescriptor& scene : scenes())
    if (!scene.needs_mesh) names[py::str(scene.name)] = scene.description;
  return names;
}

void check_name(const std::string& name) {
  const py::dict names = scene_names();
  if (names.contains(py::str(name))) return;
  std::vector<std::string> known;
  for (const auto& row : names) known.push_back(row.first.cast<std::string>());
  throw ConfigError(
      fmt::format("no scene '{}'; there are {}{}", name, fmt::join(known, ", "), did_you_mean(name, known)));
}

/// Whether the following line may take long.
void check_simulated(const std::string& name, bool simulate) {
  BakeSettings settings;
  const SimulatedScene* scene = simulated(name, settings);
  if (!scene || simulate || std::filesystem::exists(baked_file(*scene, settings))) return;
  throw InputError(baked_file(*scene, settings), "",
                   fmt::format("the scene '{}' has not been simulated yet, which takes minutes: call "
                               "volccd.scene('{}', simulate=True), or run `volccd scene generate {}`",
                               name, name, name));
}

std::string scene_file(const std::string& name, bool simulate, unsigned threads) {
  check_name(name);
  check_simulated(name, simulate);
  const py::gil_scoped_release without_gil;
  const auto executor = make_signal_executor(threads);
  std::exception_ptr raised;
  BakeHooks hooks;
  hooks.interrupted = [&raised] {
    try {
      check_signals();
      return false;
    } catch (const py::error_already_set&) {
      raised = std::current_exception();
      return true;
    }
  };
  const std::optional<std::string> file = resolve_scene(name, *executor, hooks);
  if (!file) std::rethrow_exception(raised);
  return *file;
}

}  // namespace

void bind_scenes(py::module_& module) {
  module.def("scene_names", &scene_names);
  module.def("scene_file", &scene_file);
}

}  // namespace volccd::python
