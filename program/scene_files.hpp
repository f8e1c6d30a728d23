// Names of scenes in place of files, on the command line.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include <volccd/core/error.hpp>
#include <volccd/experiments/scenes/simulated/bake.hpp>
#include <volccd/mesh/sequence/reader.hpp>
#include <volccd/program/progress.hpp>

namespace volccd {

/// Shows how far a bake is, within a frame as well, and how long it will take; stops it at Ctrl-C, after the step of
/// the simulation that it is at. The frame begun is lost.
class BakeProgress {
 public:
  explicit BakeProgress(std::string scene) : scene_(std::move(scene)) {}

  BakeHooks hooks();

 private:
  std::string scene_;
  InterruptGuard guard_;
  std::unique_ptr<Progress> progress_;
  int first_ = 0;
};

/// resolve_scene() with progress. Throws InputError, with near names of scenes, for what is neither a file nor a scene.
/// `threads`: for baking; 0: as many as the machine has. Throws Interrupted as well.
std::string sequence_file(const std::string& name_or_file, unsigned threads = 0);

/// The command that simulates a scene, "NAME" or "NAME-quick", and keeps it in the cache.
std::string simulating_command(const std::string& scene);

/// The same for commands that only look: what would have to be simulated first is a ConfigError that names the command
/// for it. (A scene that is computed from nothing takes less than a second, and is.)
std::string present_sequence_file(const std::string& name_or_file);

/// Says on stderr that a sequence ends before the last step that was meant for it, if it does.
void warn_of_incomplete(const SequenceReader& reader);

/// scene_record().
using RecordOfScene = std::optional<nlohmann::json> (*)(
    const std::string& name, const std::string& sequence, const std::string& bake_record, Executor& executor,
    const std::function<bool(std::size_t done, std::size_t motions)>& go_on);

/// With progress, and its own executor, that stops within a step. Throws Interrupted as well.
nlohmann::json record_with_progress(const std::string& name, const std::string& sequence,
                                    const std::string& bake_record, unsigned threads, RecordOfScene measure);

}  // namespace volccd
