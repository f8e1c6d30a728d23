// Names of scenes that the command line accepts instead of files.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include <volccd/core/error.hpp>
#include <volccd/experiments/scenes/simulated/bake.hpp>
#include <volccd/io/sequence/reader.hpp>
#include <volccd/program/progress.hpp>

namespace volccd {

/// Shows the progress of a bake, also within a frame, and the remaining time. Ctrl-C stops the bake after the present
/// step of the simulation; the incomplete frame is discarded.
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

/// resolve_scene() with progress. Throws InputError, with similar names of scenes, for a name that is neither a file
/// nor a scene. `threads`: for baking; 0: as many as the machine has. Throws Interrupted as well.
std::string sequence_file(const std::string& name_or_file, unsigned threads = 0);

/// The command that simulates a scene, by a name of scene_to_bake(), and keeps it in the cache.
std::string simulating_command(const std::string& scene);

/// The same for commands that do not simulate. Throws ConfigError, which names the command to run first, for a scene
/// that would have to be simulated. (A scene that is given by a formula is generated, which takes less than a second.)
std::string present_sequence_file(const std::string& name_or_file);

/// Prints a warning on stderr if the sequence is incomplete.
void warn_of_incomplete(const SequenceReader& reader);

/// scene_record().
using RecordOfScene = std::optional<nlohmann::json> (*)(
    const std::string& name, const std::string& sequence, const std::string& bake_record, Executor& executor,
    const std::function<bool(std::size_t done, std::size_t steps)>& go_on);

/// Shows progress, and uses an executor of its own that stops within a step. Also throws Interrupted.
nlohmann::json record_with_progress(const std::string& name, const std::string& sequence,
                                    const std::string& bake_record, unsigned threads, RecordOfScene measure);

}  // namespace volccd
