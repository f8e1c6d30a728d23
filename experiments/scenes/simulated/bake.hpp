// Baking: a simulated scene is computed once, into a sequence file that all see.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include <volccd/core/executor.hpp>
#include <volccd/experiments/scenes/simulated/simulated_scene.hpp>
#include <volccd/mesh/sequence/metadata.hpp>

namespace volccd {

/// What a file in the cache is known by, together with the scene's name and version.
struct BakeSettings {
  int elements = 0;  ///< about; 0: the scene's default
  int frames = 0;    ///< at least 2; 0: the scene's
  std::uint64_t seed = 1;
};

struct BakeHooks {
  /// After each frame, and once before the first that is missing: how many are done.
  std::function<void(int done, int frames)> progress = {};
  /// Asked before each frame and after each step of the simulation: whether to stop.
  std::function<bool()> interrupted = {};
  /// After each step of the simulation but the last of a frame: how many frames are done, and what share of the next
  /// one's time, in (0, 1), ascending.
  std::function<void(int done, double share)> within_frame = {};
};

/// Folder of baked scenes: VOLCCD_CACHE, else $XDG_CACHE_HOME/volccd, else ~/.cache/volccd, else ./.volccd-cache.
std::string bake_cache_folder();

/// Where bake() puts the file, whether or not it is there.
std::string baked_file(const SimulatedScene& scene, const BakeSettings& settings);

/// The record of the run beside it (JSON): settings, machine, and per frame times, contacts that met a response,
/// topology edits, energy.
std::string bake_record_file(const SimulatedScene& scene, const BakeSettings& settings);

/// Returns baked_file() once it is complete: at once if it was there. Else runs the simulation, frame by frame, each
/// frame and the state after it kept beside the target, so that a bake that stopped goes on after its last whole frame.
/// (Not if another build made it: then it starts anew.) Nothing when `interrupted` said so. The same bytes in all
/// arrays for any number of workers, with or without interruption. Throws ConfigError for settings out of range,
/// InputError for what the system refuses, Error when another process bakes the same, and what Simulation throws.
std::optional<std::string> bake(const SimulatedScene& scene, const BakeSettings& settings, Executor& executor,
                                const BakeHooks& hooks = {});

/// Title, units (SI), names of the parts.
SequenceMetadata bake_metadata(const SimulatedScene& scene, const BakeSettings& settings,
                               const simulation::Model& model);

/// Copies a file by way of a temporary name beside the target. Throws InputError.
void copy_file_whole(const std::string& from, const std::string& to);

}  // namespace volccd
