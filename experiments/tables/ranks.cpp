#include <volccd/experiments/tables/ranks.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/distributed/in_process_detector.hpp>
#include <volccd/experiments/harness/motion_measures.hpp>
#include <volccd/experiments/harness/subdivide.hpp>
#include <volccd/experiments/tables/rows.hpp>
#include <volccd/pipelines/step_runner.hpp>

namespace volccd {

using nlohmann::json;

namespace {

constexpr int kRankRounds = 5;
/// Steps that are not measured: with the first, ranks make their pieces; then regions follow measured times.
constexpr int kRankWarmUps = 12;

/// A motion of the mesh: a part of that between two frames, and how far ahead lists of elements are made
/// (Config::skin).
struct RankMotion {
  const char* name;
  double scale, skin;
};
constexpr RankMotion kRankMotions[] = {{"frame", 1, 0}, {"substep", 0.01, 0.2}, {"rest", 0, 0.2}};

/// One mesh: a scene, divided some times.
struct RankCase {
  TableScene scene;
  int divisions = 0;
  std::vector<int> ranks;
};

std::vector<RankCase> rank_cases(const PlanContext& context) {
  std::vector<RankCase> cases;
  for (const TableScene& scene : table_and_large_scenes(context)) {
    const bool own = !context.own_scenes.empty();
    const bool octopus = scene.name == "octopus2-105k-deformed", crash = scene.name == "crash";
    if (!context.full) {
      if (own || scene.name == "octopi") cases.push_back({scene, 0, {2, 4, 16}});
      if (octopus) cases.push_back({scene, 0, {16}});
      continue;
    }
    if (own || octopus || crash || scene.name == "openradioss-crash" || scene.name == "cloth-ball")
      cases.push_back({scene, 0, {2, 4, 16, 64}});
    // 843,520 tetrahedra, and 0.96 M shells: both without edits.
    if (octopus) cases.push_back({scene, 1, {16, 128, 512}});
    if (crash) cases.push_back({scene, 2, {16, 128, 512}});
  }
  return cases;
}

struct RankMesh {
  std::unique_ptr<SequenceReader> reader;
  std::unique_ptr<SequenceStepper> stepper;
  std::optional<Topology> divided;
  Motion motion;
  bool thickened = false;  ///< the mesh has three vertices for each vertex of a shell
  int step = 0;

  const Topology& topology() const { return divided ? *divided : stepper->topology(); }
};

/// The mesh in the middle of the sequence. A divided mesh moves half as far for each division, as in the table of
/// scaling, so that the motion is the same in edges.
RankMesh load(const RankCase& one, Executor& executor) {
  RankMesh mesh;
  mesh.reader = std::make_unique<SequenceReader>(one.scene.file);
  const SequenceStepper::Config config = table_config(one.scene.file);
  mesh.stepper = std::make_unique<SequenceStepper>(*mesh.reader, config);
  mesh.step = mesh.stepper->step_count() / 2;
  mesh.stepper->go_to(mesh.step, executor);
  mesh.motion = mesh.stepper->motion();
  const bool solid = config.shells == ShellModel::solid;
  mesh.thickened = solid && one.divisions == 0;
  if (one.divisions == 0) return mesh;
  RefinedStep fine =
      refine(mesh.stepper->topology(), mesh.motion, one.divisions, solid ? Division::in_plane : Division::everywhere);
  mesh.motion = scaled(fine.motion, std::pow(0.5, one.divisions));
  mesh.divided.emplace(std::move(fine.mesh), executor);
  return mesh;
}

/// What the ranks did in one step.
json columns_of_ranks(std::span<const distributed::RankStatistics> ranks, std::size_t elements) {
  double slowest = 0, pipeline = 0;
  distributed::RankStatistics all;
  std::uint64_t bytes = 0;
  for (const distributed::RankStatistics& rank : ranks) {
    slowest = std::max(slowest, rank.seconds + rank.piece_seconds);
    pipeline = std::max(pipeline, rank.seconds);
    bytes = std::max(bytes, rank.bytes_received);
    all += rank;
  }
  const double n = static_cast<double>(ranks.size());
  return {{"slowest_s", slowest},
          {"slowest_pipeline_s", pipeline},
          {"sum_s", all.seconds + all.piece_seconds},
          {"pipeline_sum_s", all.seconds},
          {"imbalance", all.seconds > 0 ? pipeline * n / all.seconds : 1},
          {"copies", static_cast<double>(all.elements) / static_cast<double>(elements)},
          {"halo", static_cast<double>(all.halo) / static_cast<double>(elements)},
          {"tests", all.tests},
          {"bytes_max", bytes},
          {"bytes_mean", static_cast<double>(all.bytes_received) / n},
          {"neighbours_max", all.neighbours},
          {"lists", ranks.front().lists}};
}

constexpr Request kRequest{.count_adjacent = false};

/// Several numbers of ranks on one mesh with one motion.
class RankComparison {
 public:
  RankComparison(const PlanContext& context, const RankCase& one, const RankMesh& mesh, const RankMotion& motion)
      : one_(one),
        mesh_(mesh),
        motion_(motion),
        moved_(scaled(mesh.motion, motion.scale)),
        executor_(context.executor ? *context.executor : serial_executor()) {
    const PipelineSpec spec = entrant(context.registry, "", "VolCCD+", {"inclusion.undecided=exact"}).spec;
    whole_.emplace(StepRunner(Pipeline(context.registry, spec),
                              {.executor = &executor_, .leave_out_shell_neighbours = mesh.thickened}));
    for (const int ranks : one.ranks)
      ranks_.emplace_back(
          ranks, context.registry, spec,
          distributed::Config{
              .executor = &executor_, .leave_out_shell_neighbours = mesh.thickened, .skin = motion.skin});
  }

  std::vector<json> run(const std::function<void()>& before_each) {
    std::vector<json> rows;
    for (int round = -kRankWarmUps; round < kRankRounds; ++round) {
      before_each();
      const StepResult& expected = whole_->run(mesh_.topology(), moved_, kRequest);
      for (std::size_t i = 0; i < ranks_.size(); ++i) {
        before_each();
        const StepResult& found = ranks_[i].step(mesh_.topology(), moved_, kRequest);
        if (found.contacts != expected.contacts)
          throw ConfigError(fmt::format(
              "ranks: {} divided {} times, {} ranks: {} contacts, or others than the {} of the "
              "whole mesh",
              one_.scene.name, one_.divisions, one_.ranks[i], found.contacts.size(), expected.contacts.size()));
        if (round >= 0) rows.push_back(row(ranks_[i], one_.ranks[i], expected, round));
      }
    }
    return rows;
  }

 private:
  json row(const distributed::InProcessDetector& detector, int ranks, const StepResult& whole, int round) const {
    const std::size_t elements = mesh_.topology().mesh().element_count();
    json result = columns_of_ranks(detector.statistics(), elements);
    result.update({{"scene", one_.scene.name},
                   {"divisions", one_.divisions},
                   {"case", motion_.name},
                   {"ranks", ranks},
                   {"round", round},
                   {"step", mesh_.step},
                   {"warm_ups", kRankWarmUps},
                   {"threads", executor_.workers()},
                   {"elements", elements},
                   {"whole_s", whole.statistics.seconds},
                   {"whole_tests", whole.statistics.tests()},
                   {"contacts", whole.contacts.size()}});
    return result;
  }

  const RankCase& one_;
  const RankMesh& mesh_;
  const RankMotion motion_;
  const Motion moved_;
  Executor& executor_;
  std::optional<StepRunner> whole_;
  std::vector<distributed::InProcessDetector> ranks_;
};

/// A network, for the model of a step's time.
constexpr double kLatency = 2e-6, kBandwidth = 10e9;  ///< s, bytes/s
/// In a step whose lists hold, a detector reduces five times over all ranks and exchanges positions twice.
constexpr int kReductions = 5, kExchanges = 2;

/// The rows of one scene, division, motion and number of ranks.
struct RankLine {
  Rows rows;

  double of(const char* column) const { return rows.median(column); }
  double speedup() const { return of("whole_s") / of("slowest_s"); }
  double overhead() const { return of("sum_s") / of("whole_s"); }
  /// Computed, not measured: the slowest rank, and what a network of this latency and bandwidth adds.
  double modelled_s() const {
    return of("slowest_s") + kLatency * (kExchanges * of("neighbours_max") + kReductions * std::log2(of("ranks"))) +
           of("bytes_max") / kBandwidth;
  }
  double test_ratio() const { return of("whole_tests") > 0 ? of("tests") / of("whole_tests") : 1; }
};

template <class Visitor>
void for_each_rank_line(const Rows& rows, Visitor&& visit) {
  for (const Rows& some : rows.groups({"case", "scene", "divisions", "ranks"})) visit(RankLine{some});
}

}  // namespace

ExperimentPlan ranks_plan(const PlanContext& context) {
  ExperimentPlan plan{"ranks", context.full ? "full" : "quick", kRankRounds, {}};
  for (const RankCase& one : rank_cases(context)) {
    plan.runs.push_back({one.scene.name, one.scene.file});
    plan.runs.back().subdivisions = one.divisions;
  }
  return plan;
}

void ranks_rows(const PlanContext& context, RecordFile& record) {
  const std::vector<RankCase> cases = rank_cases(context);
  if (cases.empty()) throw ConfigError("ranks: none of its scenes is available");
  const auto steps_of = [](const RankCase& one) { return (kRankWarmUps + kRankRounds) * (1 + one.ranks.size()); };
  std::size_t total = 0, done = 0;
  for (const RankCase& one : cases) total += std::size(kRankMotions) * steps_of(one);
  const auto before_each = [&] {
    if (context.progress) context.progress(done++, total);
  };
  for (const RankCase& one : cases) {
    std::optional<RankMesh> mesh;
    for (const RankMotion& motion : kRankMotions) {
      const std::string part = fmt::format("{} divided {} times, {}", one.scene.name, one.divisions, motion.name);
      if (record.has(part)) {
        done += steps_of(one);
        continue;
      }
      if (!mesh) mesh = load(one, context.executor ? *context.executor : serial_executor());
      record.add(part, RankComparison(context, one, *mesh, motion).run(before_each));
    }
  }
}

std::vector<TitledTable> ranks_tables(const json& record) {
  const Rows rows(record);
  TextTable times({"scene", "motion", "elements", "ranks", "whole, ms", "slowest, ms", "whole / slowest", "all / whole",
                   "model, ms"},
                  4);
  TextTable pieces({"scene", "motion", "elements", "ranks", "copies", "halo", "imbalance", "tests / whole",
                    "neighbours", "KB mean", "KB most"},
                   4);
  for_each_rank_line(rows, [&](const RankLine& line) {
    const json& first = line.rows.front();
    const std::vector<std::string> labels = {first.at("scene"), first.at("case"),
                                             grouped(first.at("elements").get<std::uint64_t>()),
                                             std::to_string(first.at("ranks").get<int>())};
    const auto add = [&](TextTable& table, std::vector<std::string> cells) {
      cells.insert(cells.begin(), labels.begin(), labels.end());
      table.add(std::move(cells));
    };
    add(times, {number_text(1e3 * line.of("whole_s")), number_text(1e3 * line.of("slowest_s")),
                ratio_text(line.speedup()), fixed_text(line.overhead(), 2), number_text(1e3 * line.modelled_s())});
    add(pieces, {fixed_text(line.of("copies"), 2), fixed_text(line.of("halo"), 2), fixed_text(line.of("imbalance"), 2),
                 fixed_text(line.test_ratio(), 2), number_text(line.of("neighbours_max")),
                 number_text(line.of("bytes_mean") / 1e3), number_text(line.of("bytes_max") / 1e3)});
  });
  return {
      {"Ranks: one step of VolCCD+, ranks in one process, one after another", times,
       fmt::format(
           "medians of {} rounds after {} steps, in which regions follow measured times; motion: between two frames, "
           "of a hundredth of it with lists that hold, or none; "
           "slowest: rank, pipeline with boxes, lists and piece; all: the sum over ranks; model: computed, not "
           "measured: the slowest rank, and on a network of {:.0f} us latency and {:.0f} GB/s for each rank, {} "
           "exchanges with the neighbours, {} reductions, and the bytes of the rank that receives most\n",
           rows.values("round").size(), rows.median("warm_ups"), 1e6 * kLatency, kBandwidth / 1e9, kExchanges,
           kReductions)},
      {"Ranks: pieces and messages", pieces,
       "copies: elements of all ranks over those of the mesh; halo: those around the pieces, whose stars alone are "
       "classified; imbalance: slowest pipeline over the mean; "
       "neighbours: most that one rank receives positions from; KB: received by a rank, elements included where "
       "lists are made\n"}};
}

json ranks_summary(const json& record) {
  json summary = json::array();
  for_each_rank_line(Rows(record), [&](const RankLine& line) {
    json one = {{"whole_ms", 1e3 * line.of("whole_s")},  {"slowest_ms", 1e3 * line.of("slowest_s")},
                {"speedup_slowest", line.speedup()},     {"overhead", line.overhead()},
                {"copies", line.of("copies")},           {"test_ratio", line.test_ratio()},
                {"modelled_ms", 1e3 * line.modelled_s()}};
    for (const char* column : {"scene", "case", "divisions", "elements", "ranks"})
      one[column] = line.rows.front().at(column);
    summary.push_back(std::move(one));
  });
  return summary;
}

}  // namespace volccd
