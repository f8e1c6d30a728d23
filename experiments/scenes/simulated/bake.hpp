// Baking: computes a simulated scene once and stores it as a sequence file in a cache.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include <volccd/core/executor.hpp>
#include <volccd/experiments/scenes/simulated/simulated_scene.hpp>
#include <volccd/io/sequence/metadata.hpp>

namespace volccd {

/// Settings that, with the scene's name and version, identify a file in the cache.
struct BakeSettings {
  int elements = 0;  ///< approximate number; 0: the scene's default
  int frames = 0;    ///< at least 2; 0: the scene's default
  std::uint64_t seed = 1;
};

struct BakeHooks {
  /// Called with the number of complete frames, after each frame and before the first one that is computed.
  std::function<void(int done, int frames)> progress = {};
  /// Called before each frame and after each step of the simulation; returns whether to stop.
  std::function<bool()> interrupted = {};
  /// Called after each step of the simulation except for the last step of a frame, with the number of complete frames
  /// and the fraction of the next one that is done, in (0, 1), ascending.
  std::function<void(int done, double share)> within_frame = {};
};

/// Folder of baked scenes: VOLCCD_CACHE, else $XDG_CACHE_HOME/volccd, else ~/.cache/volccd, else ./.volccd-cache.
std::string bake_cache_folder();

/// Makes a folder in the cache, or the cache itself, if it is not there, and returns it. Throws InputError, which names
/// VOLCCD_CACHE, if it cannot be made or written to.
std::string make_cache_folder(std::string folder);

/// The file that bake() writes, whether or not it exists.
std::string baked_file(const SimulatedScene& scene, const BakeSettings& settings);

/// The record of the run, stored beside it (JSON): settings, machine, and for each frame times, contacts that got a
/// response, topology edits, and energy.
std::string bake_record_file(const SimulatedScene& scene, const BakeSettings& settings);

/// Returns baked_file(), which it computes if it does not exist. Each frame and the state after it are stored beside
/// the target, so that an interrupted run continues after its last complete frame (unless a different build made these
/// files; then it starts from the beginning). Returns nothing if `interrupted` returned true. All arrays have the same
/// bytes for any number of workers, with or without interruptions. Throws ConfigError for settings out of range,
/// InputError for errors of the file system, Error if another process bakes the same file, and the exceptions of
/// Simulation.
std::optional<std::string> bake(const SimulatedScene& scene, const BakeSettings& settings, Executor& executor,
                                const BakeHooks& hooks = {});

/// Metadata of the sequence: title, units (SI), names of the bodies.
SequenceMetadata bake_metadata(const SimulatedScene& scene, const BakeSettings& settings,
                               const simulation::Model& model);

/// Copies a sequence file; writes as OutputFile does. Throws InputError.
void copy_file_whole(const std::string& from, const std::string& to);

}  // namespace volccd
