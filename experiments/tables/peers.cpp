#include <volccd/experiments/tables/peers.hpp>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include <volccd/broadphase/candidate_pairs.hpp>
#include <volccd/core/error.hpp>
#include <volccd/experiments/scenes/deform.hpp>
#include <volccd/experiments/tables/rows.hpp>
#include <volccd/io/sequence/reader.hpp>

namespace volccd {

using nlohmann::json;

namespace {

/// A broad phase and its options. `boxes`: it emits the pairs of elements whose swept boxes overlap.
struct Contender {
  const char* broad_phase;
  OptionValues options;
  bool boxes = true, peer = false;
};

/// Broad phases of other libraries, with each update method that may be their fastest.
std::vector<Contender> contenders(const Registry& registry) {
  std::vector<Contender> all = {{"kdop-bvh", {{"k", "6"}}},
                                {"kdop-bvh", {{"k", "6"}, {"restructure", "always"}}},
                                {"kdop-bvh", {{"k", "16"}}, false},
                                {"spatial-hash", {{"k", "6"}}}};
  const std::vector<Contender> peers = {{"fcl-dynamic-tree", {{"update", "refit"}}},
                                        {"fcl-dynamic-tree", {{"update", "build"}}},
                                        {"bullet-dbvt", {{"update", "refit"}}},
                                        {"bullet-dbvt", {{"update", "leaves"}}},
                                        {"bullet-dbvt", {{"update", "build"}}},
                                        {"embree-collide", {{"update", "refit"}}},
                                        {"embree-collide", {{"update", "build"}, {"quality", "low"}}},
                                        {"embree-collide", {{"update", "build"}, {"quality", "medium"}}},
                                        {"cgal-box-intersection", {}}};
  for (Contender peer : peers)
    for (const auto& stage : registry.stages<BroadPhase>())
      if (stage.name == peer.broad_phase) {
        peer.peer = true;
        all.push_back(peer);
      }
  return all;
}

std::string variant_of(const Contender& contender) {
  std::string text;
  for (const auto& [name, value] : contender.options) text += (text.empty() ? "" : " ") + name + "=" + value;
  return text;
}

/// Some steps of a scene, each with the one before it.
class SceneMotions {
 public:
  virtual ~SceneMotions() = default;
  virtual std::vector<int> steps(bool full) const = 0;
  /// Begins a round of a step by going to the step before it.
  virtual void go_before(int step) = 0;
  virtual void go_to(int step) = 0;

  Step step() const { return {*topology_, motion_, everything_}; }

 protected:
  /// A motion that leads to the start of the present one with the same velocities.
  void go_back() {
    for (Index v = 0; v < motion_.vertex_count(); ++v) {
      const Vec3 x0 = motion_.point(v, 0), x1 = motion_.point(v, 1);
      motion_.set(v, 0, x0 - (x1 - x0));
      motion_.set(v, 1, x0);
    }
  }

  const Topology* topology_ = nullptr;
  Motion motion_;

 private:
  ObjectFilter everything_;
};

class MotionsOfFile final : public SceneMotions {
 public:
  explicit MotionsOfFile(const std::string& file) : reader_(file), config_(table_config(file)) {}

  std::vector<int> steps(bool full) const override {
    std::vector<int> result;
    for (const StepWindow& window : sampled_windows(reader_.frame_count() - 1, full ? 4 : 2, 1))
      for (int k = 0; k < window.count; ++k) result.push_back(window.first + k);
    return result;
  }

  /// Where cells change, a new stepper makes the edit happen in each round in the same way.
  void go_before(int step) override {
    const bool edits =
        step > 0 && stepper_ && !reader_.same_cells(stepper_->cells_frame(step - 1), stepper_->cells_frame(step));
    if (!stepper_ || edits) stepper_.emplace(reader_, config_);
    go_to(std::max(step - 1, 0));
    if (step == 0) go_back();
  }

  void go_to(int step) override {
    stepper_->go_to(step);
    topology_ = &stepper_->topology();
    motion_ = stepper_->motion();
  }

 private:
  SequenceReader reader_;
  const SequenceStepper::Config config_;
  std::optional<SequenceStepper> stepper_;
};

/// A mesh that is turned by 10 degrees about its long axis, and shortened by 5 %, in one step.
class TurnedMesh final : public SceneMotions {
 public:
  explicit TurnedMesh(const std::string& file) {
    DeformConfig config;
    config.motions = {{DeformKind::twist, 10}, {DeformKind::squeeze, 0.05}};
    const std::unique_ptr<Scene> scene = make_deform(shape_from_file(file), config);
    own_.emplace(scene_mesh(*scene, 0));
    topology_ = &*own_;
    scene->positions(0, x0_);
    scene->positions(1, x1_);
  }

  std::vector<int> steps(bool) const override { return {0}; }
  void go_before(int step) override {
    go_to(step);
    go_back();
  }
  void go_to(int) override { motion_ = Motion::linear(x0_, x1_); }

 private:
  std::optional<Topology> own_;
  std::vector<Vec3> x0_, x1_;
};

struct NamedScene {
  std::string name, file;
  bool turned = false;
};

std::vector<NamedScene> named_scenes(const PlanContext& context) {
  std::vector<NamedScene> scenes;
  for (const TableScene& scene : table_scenes(context)) scenes.push_back({scene.name, scene.file});
  for (const char* name : {"octopus2-105k", "cloth-ball", "rod-twist"})
    if (const std::optional<std::string> file = context.file_of(name))
      scenes.push_back({name, *file, std::string(name) == "octopus2-105k"});
  return scenes;
}

bool is_volume(const Mesh& mesh) {
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.is_live(o)) return mesh.type(o) != ElementType::triangle && mesh.type(o) != ElementType::quad;
  return false;
}

/// A contender with its state in one scene.
class Racer {
 public:
  Racer(const Registry& registry, const Contender& contender)
      : contender_(&contender),
        phase_(registry.stage<BroadPhase>(contender.broad_phase).make(contender.options)),
        state_(phase_->make_state()) {}

  const Contender& contender() const { return *contender_; }

  /// Runs a broad phase on a step, and counts the pairs that it writes.
  json run(Step step, Executor& executor) {
    step.range = PairRange::nonadjacent;
    using Clock = std::chrono::steady_clock;
    struct alignas(64) Count {
      std::uint64_t pairs = 0;
    };
    std::vector<Count> counts(executor.workers());
    const auto ms = [](Clock::duration time) { return std::chrono::duration<double, std::milli>(time).count(); };
    const auto begun = Clock::now();
    phase_->prepare(step, *state_, executor);
    const auto prepared = Clock::now();
    visit_candidates(*phase_, step, *state_, executor, [&](std::span<const ElementPair> pairs, unsigned worker) {
      counts[worker].pairs += pairs.size();
    });
    const auto ended = Clock::now();
    std::uint64_t pairs = 0;
    for (const Count& count : counts) pairs += count.pairs;
    return {{"broadphase", contender_->broad_phase},
            {"variant", variant_of(*contender_)},
            {"boxes", contender_->boxes},
            {"peer", contender_->peer},
            {"build_ms", ms(prepared - begun)},
            {"query_ms", ms(ended - prepared)},
            {"pairs", pairs},
            {"pairs_per_second", static_cast<double>(pairs) / (1e-3 * ms(ended - begun))},
            {"bytes", state_->bytes()}};
  }

 private:
  const Contender* contender_;
  std::unique_ptr<BroadPhase> phase_;
  std::unique_ptr<StageState> state_;
};

/// Throws Error unless all broad phases with the same boxes emit the same number of pairs.
void expect_same_pairs(const std::vector<json>& rows) {
  const json* first = nullptr;
  for (const json& row : rows) {
    if (!row.at("boxes").get<bool>()) continue;
    if (!first) first = &row;
    if (row.at("pairs") == first->at("pairs")) continue;
    const auto text = [](const json& r) {
      return fmt::format("{} {} emits {} pairs", r.at("broadphase").get<std::string>(),
                         r.at("variant").get<std::string>(), r.at("pairs").get<std::uint64_t>());
    };
    throw Error(
        fmt::format("peers, {}, step {}: {}, {}: one of them loses or invents pairs; `volccd check` on its "
                    "name may find a small case",
                    row.at("scene").get<std::string>(), row.at("step").get<int>(), text(*first), text(row)));
  }
}

/// Runs all broad phases on a step, in an order that shifts by one from round to round.
std::vector<json> run_round(SceneMotions& scene, const std::string& name, int step, int round,
                            std::vector<Racer>& racers, Executor& executor) {
  scene.go_before(step);
  for (Racer& racer : racers) racer.run(scene.step(), executor);
  scene.go_to(step);
  const Mesh& mesh = scene.step().mesh();
  std::vector<json> rows;
  for (std::size_t i = 0; i < racers.size(); ++i) {
    json row = {{"scene", name},  {"volume", is_volume(mesh)},    {"elements", mesh.element_count()}, {"step", step},
                {"round", round}, {"threads", executor.workers()}};
    row.update(racers[(i + static_cast<std::size_t>(round)) % racers.size()].run(scene.step(), executor));
    rows.push_back(std::move(row));
  }
  expect_same_pairs(rows);
  return rows;
}

struct Times {
  std::string name;
  bool peer;
  double build, query, both;  ///< ms; means over steps of medians over rounds
  std::uint64_t pairs;
  double bytes;
};

/// One for each contender of a scene, in the order of the rows.
std::vector<Times> times_of(const Rows& rows) {
  std::vector<Times> result;
  for (const Rows& of : rows.groups({"broadphase", "variant"})) {
    const std::string text = of.value("variant");
    const auto mean = [&](const std::vector<std::string>& columns) { return of.mean_ms(columns) / 1e3; };
    result.push_back({of.value("broadphase").get<std::string>() + (text.empty() ? "" : " ") + text,
                      of.value("peer").get<bool>(), mean({"build_ms"}), mean({"query_ms"}),
                      mean({"build_ms", "query_ms"}), static_cast<std::uint64_t>(of.sum("pairs")), of.median("bytes")});
  }
  return result;
}

/// The time of the fastest peer; nothing if there is none.
std::optional<double> fastest_peer(const std::vector<Times>& times) {
  std::optional<double> best;
  for (const Times& one : times)
    if (one.peer) best = std::min(best.value_or(one.both), one.both);
  return best;
}

}  // namespace

ExperimentPlan peers_plan(const PlanContext& context) {
  ExperimentPlan plan{"peers", context.full ? "full" : "quick", context.full ? kFullRounds : 3, {}};
  for (const NamedScene& scene : named_scenes(context)) plan.runs.push_back({scene.name, scene.file});
  return plan;
}

void peers_rows(const PlanContext& context, RecordFile& record) {
  SerialExecutor serial;
  Executor& executor = context.executor ? *context.executor : serial;
  const std::vector<Contender> all = contenders(context.registry);
  const std::vector<NamedScene> scenes = named_scenes(context);
  if (scenes.empty()) throw ConfigError("peers: none of its scenes is available");
  const int rounds = peers_plan(context).rounds;
  for (std::size_t s = 0; s < scenes.size(); ++s) {
    if (record.has(scenes[s].name)) continue;
    std::vector<json> rows;
    std::unique_ptr<SceneMotions> scene;
    if (scenes[s].turned)
      scene = std::make_unique<TurnedMesh>(scenes[s].file);
    else
      scene = std::make_unique<MotionsOfFile>(scenes[s].file);
    std::vector<Racer> racers;
    for (const Contender& contender : all) racers.emplace_back(context.registry, contender);
    for (const int step : scene->steps(context.full))
      for (int round = 0; round < rounds; ++round) {
        if (context.progress) context.progress(s, scenes.size());
        for (json& row : run_round(*scene, scenes[s].name, step, round, racers, executor))
          rows.push_back(std::move(row));
      }
    record.add(scenes[s].name, rows);
  }
}

std::vector<TitledTable> peers_tables(const json& record) {
  const Rows rows(record);
  TextTable table({"scene", "broad phase", "elements", "update, ms", "query, ms", "both, ms", "pairs",
                   "million pairs/s", "memory", "fastest peer / this"},
                  2);
  for (const Rows& of : rows.groups({"scene"})) {
    const std::vector<Times> times = times_of(of);
    const std::optional<double> peer = fastest_peer(times);
    const double steps = static_cast<double>(of.steps());
    table.rule();
    for (const Times& one : times) {
      const double pairs = static_cast<double>(one.pairs) / steps;
      table.add({of.value("scene").get<std::string>() + (of.value("volume").get<bool>() ? "" : " (surface)"), one.name,
                 grouped(static_cast<std::uint64_t>(of.median("elements"))), number_text(one.build),
                 number_text(one.query), number_text(one.both), grouped(static_cast<std::uint64_t>(pairs)),
                 number_text(pairs / one.both / 1e3), memory(static_cast<std::size_t>(one.bytes)),
                 peer ? ratio_text(*peer / one.both) : "-"});
    }
  }
  std::string note =
      "means over steps of medians over rounds; pairs of a step, without a common vertex, all written out\n";
  if (!fastest_peer(times_of(rows)))
    note += "this build has no broad phases of other libraries (CMake: VOLCCD_PEERS)\n";
  return {{"Broad phases side by side, steady state", table, note}};
}

json peers_summary(const json& record) {
  const Rows rows(record);
  json summary = json::array();
  for (const Rows& of : rows.groups({"scene"})) {
    const std::vector<Times> times = times_of(of);
    const std::optional<double> peer = fastest_peer(times);
    for (const Times& one : times)
      summary.push_back({{"scene", of.value("scene")},
                         {"volume", of.value("volume")},
                         {"broadphase", one.name},
                         {"peer", one.peer},
                         {"build_ms", one.build},
                         {"query_ms", one.query},
                         {"pairs", one.pairs},
                         {"speedup_fastest_peer", peer ? json(*peer / one.both) : json()}});
  }
  return summary;
}

}  // namespace volccd
