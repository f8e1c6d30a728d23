// Scenes as files: turns the name of a scene into a sequence file that any command can read.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/experiments/scenes/simulated/bake.hpp>

namespace volccd {

/// A sequence that is not part of the project; its file is `name`.vtkhdf in the folder of shared_data_path().
struct ExternalScene {
  std::string name;
  std::string description;  ///< one line
};

/// The sequences whose files exist, among ls-dyna-projectile, openradioss-bullet, openradioss-airbag,
/// openradioss-crash.
std::vector<ExternalScene> external_scenes();

std::string external_scene_file(const ExternalScene& scene);

/// Whether this is the name of a synthetic motion of a mesh of the shared data: octopus2-105k-deformed, turned by 10
/// degrees and shortened by 5 % of its length in each of four motions.
bool is_deformed_scene(const std::string& name);

/// Computes such a scene and returns its file in the cache; nothing if the mesh is not available. Throws the exceptions
/// of write_scene().
std::optional<std::string> deformed_scene_file(const std::string& name);

/// A simulated scene with settings, as a name gives them: NAME, NAME-quick, NAME-seed-N, NAME-quick-seed-N.
struct SceneToBake {
  const SimulatedScene* scene = nullptr;
  BakeSettings settings = {};
};

/// Nothing if it is no such name.
std::optional<SceneToBake> scene_to_bake(const std::string& name);

/// The file in the cache, whether or not it exists, of the simulated scene that resolve_scene() takes `name_or_file`
/// for; nothing if it is something else.
std::optional<std::string> file_to_simulate(const std::string& name_or_file);

/// The sequence file for an argument `name_or_file`, which may be
///   - the path of an existing file;
///   - the name of an external scene;
///   - a name of scene_to_bake(): its file in the cache, computed if it is missing;
///   - the name of a scene that needs no input (`builtin`), which is then written to the cache.
/// Any other text is returned unchanged, so that opening it gives an error message. The first of these that applies
/// counts. Returns nothing if the hooks interrupted the computation. Throws the exceptions of bake() and write_scene().
std::optional<std::string> resolve_scene(const std::string& name_or_file, Executor& executor,
                                         const BakeHooks& hooks = {});

}  // namespace volccd
