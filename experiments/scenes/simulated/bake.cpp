#include <volccd/experiments/scenes/simulated/bake.hpp>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <volccd/core/error.hpp>
#include <volccd/experiments/scenes/simulated/frame_store.hpp>
#include <volccd/io/build_facts.hpp>
#include <volccd/io/output_file.hpp>
#include <volccd/io/sequence/writer.hpp>
#include <volccd/io/stats_json.hpp>

namespace volccd {

namespace {

namespace fs = std::filesystem;
using simulation::Simulation;

/// Must be increased when the files that bake() makes from the same frames change.
constexpr int kFormat = 1;

BakeSettings complete(const SimulatedScene& scene, BakeSettings settings) {
  if (settings.elements == 0) settings.elements = scene.default_elements;
  if (settings.frames == 0) settings.frames = scene.frames;
  if (settings.elements < 1) throw ConfigError(scene.name + ": elements is not positive");
  if (settings.frames < 2 || settings.frames > 100'000)
    throw ConfigError(scene.name + ": frames is not in 2 .. 100000");
  return settings;
}

std::string stem(const SimulatedScene& scene, const BakeSettings& given) {
  const BakeSettings settings = complete(scene, given);
  return (fs::path(bake_cache_folder()) / fmt::format("{}-{}-elements-{}-steps-seed-{}-version-{}.{}", scene.name,
                                                      settings.elements, settings.frames, settings.seed, scene.version,
                                                      kFormat))
      .string();
}

/// A lock for one process at a time, which is released when the process ends.
class FolderLock {
 public:
  explicit FolderLock(const std::string& folder)
      : file_(open((folder + "/lock").c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644)) {
    if (file_ < 0) throw InputError(folder, "lock", "cannot be opened");
    if (flock(file_, LOCK_EX | LOCK_NB) == 0) return;
    close(file_);
    throw Error(folder + ": another process is baking this scene");
  }
  ~FolderLock() { close(file_); }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_;
};

/// A bake in progress: the frames so far, and the state after the last.
class Workplace {
 public:
  explicit Workplace(std::string folder) : folder_(make_cache_folder(std::move(folder))), lock_(folder_) {}

  std::string frame_file(int k) const { return fmt::format("{}/frame-{:05}", folder_, k); }

  std::vector<std::string> frame_files(int frames) const {
    std::vector<std::string> files;
    for (int k = 0; k < frames; ++k) files.push_back(frame_file(k));
    return files;
  }

  /// Returns the number of complete frames and reads the state after the last of them into `simulation`. Returns 0 if
  /// there are no usable files; `simulation` is then in any state.
  int restore(Simulation& simulation) const {
    std::ifstream in(folder_ + "/state", std::ios::binary);
    std::string build;
    if (!in || !std::getline(in, build) || build != signature()) return 0;
    try {
      simulation::Archive archive(in);
      std::int64_t done = 0;
      archive(done);
      for (std::int64_t k = 0; k < done; ++k)
        if (!fs::exists(frame_file(static_cast<int>(k)))) return 0;
      simulation.archive(archive);
      return static_cast<int>(done);
    } catch (const InputError&) {
      return 0;
    }
  }

  void save(Simulation& simulation, int done) const {
    write_checkpoint(folder_ + "/state", [&](std::ostream& out) {
      out << signature() << '\n';
      simulation::Archive archive(out);
      std::int64_t number = done;
      archive(number);
      simulation.archive(archive);
    });
  }

  void remove_state() const {
    std::error_code ignored;
    fs::remove(folder_ + "/state", ignored);
  }

  void remove() const {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }

 private:
  /// A state is stored as the bytes in memory, so that only the same build can continue from it.
  static std::string signature() { return fmt::format("{} {}", build_facts().commit, build_facts().build_type); }

  std::string folder_;
  FolderLock lock_;
};

nlohmann::json frame_record(const Frame& frame) {
  const simulation::SimulationCounts& c = frame.counts;
  const simulation::Ledger& l = frame.ledger;
  const auto vector = [](const Vec3& v) { return nlohmann::json{v.x(), v.y(), v.z()}; };
  return {
      {"time", frame.time},
      {"seconds", frame.seconds},
      {"elements", frame.cells.size()},
      {"vertices", frame.vertex_ids.size()},
      {"substeps", c.substeps},
      {"queries", c.queries},
      {"responses", {{"inter", c.inter}, {"intra", c.intra}, {"adjacent", c.adjacent}}},
      {"leaving", c.leaving},
      {"ignored", c.ignored},
      {"held", c.held},
      {"unresolved", c.unresolved},
      {"edits", {{"splits", c.splits}, {"breaks", c.breaks}, {"merges", c.merges}, {"cuts", c.cuts}, {"all", c.edits}}},
      {"energy",
       {{"kinetic", l.kinetic},
        {"elastic", l.elastic},
        {"plastic", l.plastic},
        {"numerical", l.numerical},
        {"damping", l.damping},
        {"contact", l.contact},
        {"friction", l.friction},
        {"topology", l.topology},
        {"external", l.external},
        {"initial", l.initial},
        {"balance_error", l.balance_error()}}},
      {"mass", l.mass},
      {"momentum", vector(l.momentum)},
      {"angular_momentum", vector(l.angular_momentum)},
      {"impulse", vector(l.impulse)},
      {"angular_impulse", vector(l.angular_impulse)}};
}

/// Elements of bodies that no force moves.
std::uint64_t tool_elements(const simulation::Model& model) {
  std::vector<char> moves(model.mesh.vertex_count(), 1), is_tool(model.bodies.size(), 0);
  for (const Index v : model.fixed) moves[v] = 0;
  const auto object_of = [&](Index o) { return static_cast<std::size_t>(model.mesh.object(o)); };
  for (Index o = 0; o < model.mesh.element_slots(); ++o)
    if (model.bodies[object_of(o)].rigid)
      for (const Index v : model.mesh.vertices(o))
        if (!moves[v]) is_tool[object_of(o)] = 1;
  for (const simulation::Guide& guide : model.guides) is_tool[static_cast<std::size_t>(guide.object)] = 1;
  std::uint64_t count = 0;
  for (Index o = 0; o < model.mesh.element_slots(); ++o) count += is_tool[object_of(o)] ? 1 : 0;
  return count;
}

void write_record(const SimulatedScene& scene, const BakeSettings& settings, const simulation::Model& model,
                  const std::vector<std::string>& frames, unsigned threads) {
  nlohmann::json list = nlohmann::json::array();
  double seconds = 0;
  for (const std::string& file : frames) {
    const Frame frame = read_frame(file);
    list.push_back(frame_record(frame));
    seconds += frame.seconds;
  }
  const nlohmann::json record = {
      {"scene", scene.name},      {"elements", settings.elements}, {"tool_elements", tool_elements(model)},
      {"steps", settings.frames}, {"seed", settings.seed},         {"version", scene.version},
      {"begin", scene.begin},     {"duration", scene.duration},    {"threads", threads},
      {"seconds", seconds},       {"machine", machine_facts()},    {"frames", std::move(list)}};
  write_text_file(bake_record_file(scene, settings), record.dump(1) + "\n");
}

/// Computes one frame; returns false if interrupted.
bool advance_frame(Simulation& simulation, double time, int done, const BakeHooks& hooks) {
  const double begin = simulation.time();
  return simulation.advance_to(time, [&](double now) {
    if (hooks.within_frame) hooks.within_frame(done, (now - begin) / (time - begin));
    return !hooks.interrupted || !hooks.interrupted();
  });
}

/// Computes the frames [done, settings.frames); returns false if interrupted.
bool run_frames(const SimulatedScene& scene, const BakeSettings& settings, Simulation& simulation, int done,
                const Workplace& place, const BakeHooks& hooks) {
  if (hooks.progress) hooks.progress(done, settings.frames);
  for (int k = done; k < settings.frames; ++k) {
    if (hooks.interrupted && hooks.interrupted()) return false;
    const auto begin = std::chrono::steady_clock::now();
    const Index before = simulation.topology().mesh().vertex_count();
    if (!advance_frame(simulation, scene.begin + scene.duration * k / (settings.frames - 1), k, hooks)) return false;
    Frame frame = capture_frame(simulation, before);
    frame.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    write_frame(place.frame_file(k), frame);
    place.save(simulation, k + 1);
    if (hooks.progress) hooks.progress(k + 1, settings.frames);
  }
  return true;
}

}  // namespace

std::string bake_cache_folder() {
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return std::string(value ? value : "");
  };
  if (const std::string given = variable("VOLCCD_CACHE"); !given.empty()) return given;
  if (const std::string given = variable("XDG_CACHE_HOME"); !given.empty()) return given + "/volccd";
  if (const std::string home = variable("HOME"); !home.empty()) return home + "/.cache/volccd";
  return ".volccd-cache";
}

std::string make_cache_folder(std::string folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error && access(folder.c_str(), W_OK) != 0) error = std::error_code(errno, std::generic_category());
  if (error)
    throw InputError(folder, "",
                     "cannot be made or written to: " + error.message() +
                         "; scenes are kept in the folder that VOLCCD_CACHE names: let it name another");
  return folder;
}

std::string baked_file(const SimulatedScene& scene, const BakeSettings& settings) {
  return stem(scene, settings) + ".vtkhdf";
}

std::string bake_record_file(const SimulatedScene& scene, const BakeSettings& settings) {
  return stem(scene, settings) + ".json";
}

std::optional<std::string> bake(const SimulatedScene& scene, const BakeSettings& given, Executor& executor,
                                const BakeHooks& hooks) {
  const BakeSettings settings = complete(scene, given);
  const std::string target = baked_file(scene, settings);
  if (fs::exists(target)) return target;
  const Workplace place(stem(scene, settings) + ".partial");
  if (fs::exists(target)) return target;  // another process has been faster
  const simulation::Model model = scene.model(settings.elements, settings.seed);
  Simulation simulation(model, scene.options, executor);
  const int done = place.restore(simulation);
  if (done == 0) {
    place.remove_state();
    simulation = Simulation(model, scene.options, executor);
  }
  if (!run_frames(scene, settings, simulation, done, place, hooks)) return std::nullopt;
  const std::vector<std::string> frames = place.frame_files(settings.frames);
  write_record(scene, settings, model, frames, executor.workers());
  write_frames(frames, target, bake_metadata(scene, settings, model));
  place.remove();
  return target;
}

SequenceMetadata bake_metadata(const SimulatedScene& scene, const BakeSettings& given, const simulation::Model& model) {
  const BakeSettings settings = complete(scene, given);
  SequenceMetadata metadata;
  metadata.title = fmt::format("{}: {}", scene.name, scene.description);
  metadata.source = fmt::format("volccd scene generate {} --elements {} --frames {} --seed {} (version {})", scene.name,
                                settings.elements, settings.frames, settings.seed, scene.version);
  metadata.license = "Apache-2.0";
  metadata.units = "m (mass in kg)";
  metadata.time_unit = "second";
  for (std::size_t i = 0; i < model.bodies.size(); ++i)
    if (!model.bodies[i].name.empty()) metadata.object_names[static_cast<std::int32_t>(i) + 1] = model.bodies[i].name;
  return metadata;
}

void copy_file_whole(const std::string& from, const std::string& to) {
  std::ifstream in(from, std::ios::binary);
  if (!in) throw InputError(from, "", std::string("cannot be opened: ") + std::strerror(errno));
  OutputFile out(to, kSequenceIsNoStream);
  std::vector<char> block(1 << 20);
  do {
    in.read(block.data(), static_cast<std::streamsize>(block.size()));
    out.write({block.data(), static_cast<std::size_t>(in.gcount())});
  } while (in);
  if (in.bad()) throw InputError(from, "", std::string("cannot be read: ") + std::strerror(errno));
  out.commit();
}

}  // namespace volccd
