#include <volccd/experiments/program/scene_files.hpp>

#include <volccd/experiments/scenes/sequences.hpp>

namespace volccd {

BakeHooks BakeProgress::hooks() {
  BakeHooks hooks;
  hooks.progress = [this](int done, int frames) {
    if (!progress_) {
      // Frames of an earlier run took no time in this one.
      first_ = done;
      progress_ =
          std::make_unique<Progress>("simulating " + scene_ + ", frame", static_cast<std::size_t>(frames - done));
    }
    progress_->advance(static_cast<std::size_t>(done - first_));
  };
  hooks.interrupted = [] { return InterruptGuard::interrupted(); };
  return hooks;
}

std::string sequence_file(const std::string& name_or_file, unsigned threads) {
  const auto executor = make_executor(threads);
  BakeProgress progress(name_or_file);
  const std::optional<std::string> file = resolve_scene(name_or_file, *executor, progress.hooks());
  if (!file) throw Interrupted(name_or_file + ": stopped; the same command goes on from the last frame");
  return *file;
}

}  // namespace volccd
