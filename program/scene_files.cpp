#include <volccd/program/scene_files.hpp>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include <fmt/format.h>

#include <volccd/core/suggest.hpp>
#include <volccd/experiments/scenes/scene.hpp>
#include <volccd/experiments/scenes/sequences.hpp>
#include <volccd/experiments/tables/scene_table.hpp>

namespace volccd {

BakeHooks BakeProgress::hooks() {
  BakeHooks hooks;
  hooks.progress = [this](int done, int frames) {
    if (!progress_) {
      // Frames that an earlier run computed took no time in this run.
      first_ = done;
      progress_ = std::make_unique<Progress>("simulating " + scene_, static_cast<std::size_t>(frames - done), "frames");
    }
    progress_->advance(static_cast<std::size_t>(done - first_));
  };
  hooks.within_frame = [this](int done, double share) {
    progress_->advance(static_cast<std::size_t>(done - first_), share);
  };
  hooks.interrupted = [] { return InterruptGuard::interrupted(); };
  return hooks;
}

namespace {

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const SimulatedScene& scene : simulated_scenes()) {
    names.push_back(scene.name);
    names.push_back(scene.name + "-quick");
  }
  for (const SceneDescriptor& scene : scenes())
    if (!scene.needs_mesh) names.push_back(scene.name);
  for (const ExternalScene& scene : external_scenes()) names.push_back(scene.name);
  return names;
}

/// Throws InputError, with similar names, for a name without "." and "/" that is neither a file nor a scene.
void check_name(const std::string& name_or_file) {
  if (name_or_file.find_first_of("/.") != std::string::npos || std::filesystem::exists(name_or_file)) return;
  const std::vector<std::string> names = scene_names();
  if (scene_to_bake(name_or_file) || std::find(names.begin(), names.end(), name_or_file) != names.end()) return;
  throw InputError(
      name_or_file, "",
      "is neither a file nor a scene; `volccd scene list` has the scenes" + did_you_mean(name_or_file, names));
}

}  // namespace

std::string sequence_file(const std::string& name_or_file, unsigned threads) {
  check_name(name_or_file);
  const auto executor = make_executor(threads);
  BakeProgress progress(name_or_file);
  const std::optional<std::string> file = resolve_scene(name_or_file, *executor, progress.hooks());
  if (!file) throw Interrupted(name_or_file + ": stopped; the same command continues after the last complete frame");
  return *file;
}

std::string simulating_command(const std::string& scene) {
  const SceneToBake bake = scene_to_bake(scene).value();
  return fmt::format("volccd scene generate {}{}{} -o {}.vtkhdf", bake.scene->name,
                     bake.settings.elements > 0 ? " --quick" : "",
                     bake.settings.seed != 1 ? fmt::format(" --seed {}", bake.settings.seed) : "", scene);
}

std::string present_sequence_file(const std::string& name_or_file) {
  if (const std::optional<std::string> file = file_to_simulate(name_or_file); file && !std::filesystem::exists(*file)) {
    throw ConfigError(fmt::format("{} has not been simulated yet, which takes minutes: `{}` does it", name_or_file,
                                  simulating_command(name_or_file)));
  }
  return sequence_file(name_or_file);
}

void warn_of_incomplete(const SequenceReader& reader) {
  if (const std::string& incomplete = reader.metadata().incomplete; !incomplete.empty())
    fmt::print(stderr, "volccd: {} is incomplete: {}\n", reader.file(), incomplete);
}

nlohmann::json record_with_progress(const std::string& name, const std::string& sequence,
                                    const std::string& bake_record, unsigned threads, RecordOfScene measure) {
  const InterruptGuard guard;
  const auto executor = make_interruptible_executor(threads);
  std::unique_ptr<Progress> progress;
  try {
    const auto record = measure(name, sequence, bake_record, *executor, [&](std::size_t done, std::size_t steps) {
      if (!progress) progress = std::make_unique<Progress>(name + ": contacts and movement", steps, "steps");
      progress->advance(done);
      return !InterruptGuard::interrupted();
    });
    if (record) return *record;
  } catch (const Interrupted&) {
  }
  throw Interrupted(name + ": stopped before the statistics were complete; none are written");
}

}  // namespace volccd
