#include <volccd/program/scene_files.hpp>

#include <cstdio>

#include <fmt/format.h>

#include <volccd/experiments/scenes/sequences.hpp>
#include <volccd/experiments/tables/scene_table.hpp>

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
  hooks.within_frame = [this](int done, double share) {
    progress_->advance(static_cast<std::size_t>(done - first_), share);
  };
  hooks.interrupted = [] { return InterruptGuard::interrupted(); };
  return hooks;
}

std::string sequence_file(const std::string& name_or_file, unsigned threads) {
  const auto executor = make_executor(threads);
  BakeProgress progress(name_or_file);
  const std::optional<std::string> file = resolve_scene(name_or_file, *executor, progress.hooks());
  if (!file) throw Interrupted(name_or_file + ": stopped; the same command goes on from the last whole frame");
  return *file;
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
    const auto record = measure(name, sequence, bake_record, *executor, [&](std::size_t done, std::size_t motions) {
      if (!progress) progress = std::make_unique<Progress>(name + ": contacts and motion, step", motions);
      progress->advance(done);
      return !InterruptGuard::interrupted();
    });
    if (record) return *record;
  } catch (const Interrupted&) {
  }
  throw Interrupted(name + ": stopped before the statistics were complete; none are written");
}

}  // namespace volccd
