#include <volccd/experiments/scenes/sequences.hpp>

#include <charconv>
#include <filesystem>
#include <string_view>

#include <volccd/core/error.hpp>
#include <volccd/experiments/scenes/scene.hpp>
#include <volccd/experiments/scenes/shared_data.hpp>

namespace volccd {

namespace {

constexpr std::string_view kQuick = "-quick", kSeed = "-seed-";

/// The scene is computed each time, which takes about a second, because a file does not say which build wrote it.
std::string write_to_cache(const Scene& scene, const std::string& name) {
  const std::filesystem::path folder = make_cache_folder(bake_cache_folder());
  const std::string file = (folder / (name + ".vtkhdf")).string();
  write_scene(scene, file);
  return file;
}

struct DeformedScene {
  const char *name, *mesh, *motion, *frames;
};
constexpr DeformedScene kDeformed[] = {{"octopus2-105k-deformed", "octopus2-105k", "twist:40,squeeze:0.2", "5"}};

const DeformedScene* find_deformed(const std::string& name) {
  for (const DeformedScene& scene : kDeformed)
    if (name == scene.name) return &scene;
  return nullptr;
}

}  // namespace

std::vector<ExternalScene> external_scenes() {
  std::vector<ExternalScene> present;
  for (const ExternalScene& scene :
       {ExternalScene{"ls-dyna-projectile", "LS-DYNA: projectile through a plate, hexahedra that erode"},
        ExternalScene{"openradioss-bullet", "OpenRadioss: copper bullet through a steel plate, hexahedra that erode"},
        ExternalScene{"openradioss-airbag", "OpenRadioss: folded airbag that inflates, triangles"},
        ExternalScene{"openradioss-crash", "OpenRadioss: front of a vehicle against a wall, shells"}})
    if (std::filesystem::exists(external_scene_file(scene))) present.push_back(scene);
  return present;
}

std::string external_scene_file(const ExternalScene& scene) { return shared_data_path(scene.name + ".vtkhdf"); }

bool is_deformed_scene(const std::string& name) { return find_deformed(name) != nullptr; }

std::optional<std::string> deformed_scene_file(const std::string& name) {
  const DeformedScene* scene = find_deformed(name);
  const std::string mesh = scene ? shared_data_path(std::string(scene->mesh) + ".vtkhdf") : "";
  if (!scene || !std::filesystem::exists(mesh)) return std::nullopt;
  const Shape shape = shape_from_file(mesh);
  return write_to_cache(*make_scene("deform", {{"motion", scene->motion}, {"frames", scene->frames}}, &shape), name);
}

std::optional<SceneToBake> scene_to_bake(const std::string& name) {
  SceneToBake found;
  std::string rest = name;
  if (const std::size_t at = rest.rfind(kSeed); at != std::string::npos) {
    const char *first = rest.data() + at + kSeed.size(), *last = rest.data() + rest.size();
    const auto [end, error] = std::from_chars(first, last, found.settings.seed);
    if (error != std::errc() || end != last) return std::nullopt;
    rest.erase(at);
  }
  const bool quick = rest.ends_with(kQuick);
  if (quick) rest.erase(rest.size() - kQuick.size());
  found.scene = find_simulated_scene(rest);
  if (!found.scene) return std::nullopt;
  if (quick) found.settings.elements = found.scene->quick_elements;
  return found;
}

std::optional<std::string> file_to_simulate(const std::string& name_or_file) {
  if (std::filesystem::exists(name_or_file)) return std::nullopt;
  for (const ExternalScene& scene : external_scenes())
    if (scene.name == name_or_file) return std::nullopt;
  const std::optional<SceneToBake> found = scene_to_bake(name_or_file);
  if (!found) return std::nullopt;
  return baked_file(*found->scene, found->settings);
}

std::optional<std::string> resolve_scene(const std::string& name_or_file, Executor& executor, const BakeHooks& hooks) {
  if (std::filesystem::exists(name_or_file)) return name_or_file;
  for (const ExternalScene& scene : external_scenes())
    if (scene.name == name_or_file) return external_scene_file(scene);
  if (const std::optional<SceneToBake> found = scene_to_bake(name_or_file))
    return bake(*found->scene, found->settings, executor, hooks);
  for (const SceneDescriptor& scene : scenes())
    if (scene.name == name_or_file && !scene.needs_mesh) return write_to_cache(*make_scene(scene.name, {}), scene.name);
  return name_or_file;
}

}  // namespace volccd
