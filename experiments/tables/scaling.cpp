#include <volccd/experiments/tables/scaling.hpp>

#include <cmath>

#include <fmt/format.h>

#include <volccd/experiments/harness/motion_measures.hpp>
#include <volccd/experiments/tables/rows.hpp>
#include <volccd/io/sequence/stepper.hpp>

namespace volccd {

using nlohmann::json;

namespace {

constexpr const char* kPipelines[] = {"NavCCD", "HashCCD", "VolCCD", "VolCCD+"};

void add_entrants(const PlanContext& context, const std::string& table, const std::string& variant, SceneRun& run) {
  std::vector<std::string> pipelines(std::begin(kPipelines), std::end(kPipelines));
  pipelines.insert(pipelines.end(), context.pipelines.begin(), context.pipelines.end());
  for (const std::string& pipeline : pipelines) {
    run.entrants.push_back(entrant(context.registry, table, pipeline));
    run.entrants.back().variant = variant;
  }
}

/// Mean displacement in a sequence's middle step, in edges.
double middle_movement(const std::string& file, int step) {
  SequenceReader reader(file);
  SequenceStepper stepper(reader, table_config(file));
  stepper.go_to(step);
  return mean_moved_edges(stepper.topology().features(), stepper.motion());
}

struct Fit {
  double exponent = 0, spread = 0;
  std::size_t points = 0;
};

/// Least squares of log y over log x.
Fit fit(const std::vector<std::pair<double, double>>& points) {
  Fit result;
  double mx = 0, my = 0, n = 0;
  for (const auto& [x, y] : points)
    if (x > 0 && y > 0) mx += std::log(x), my += std::log(y), ++n;
  result.points = static_cast<std::size_t>(n);
  if (n < 2) return result;
  mx /= n, my /= n;
  double xx = 0, xy = 0, yy = 0;
  for (const auto& [x, y] : points) {
    if (!(x > 0 && y > 0)) continue;
    const double dx = std::log(x) - mx, dy = std::log(y) - my;
    xx += dx * dx, xy += dx * dy, yy += dy * dy;
  }
  if (!(xx > 0)) return result;
  result.exponent = xy / xx;
  if (n > 2) result.spread = std::sqrt(std::max(0.0, yy - xy * xy / xx) / (n - 2) / xx);
  return result;
}

/// (x, y) of all variants of a pipeline's rows, each of which has one step.
std::vector<std::pair<double, double>> curve(const Rows& rows, const std::string& x, const std::string& y) {
  std::vector<std::pair<double, double>> points;
  for (const Rows& of : rows.groups({"variant"}))
    points.emplace_back(of.median(x), y == "tests" ? of.tests() / static_cast<double>(of.steps()) : of.median(y));
  return points;
}

const char* x_of(const std::string& table) { return table == "motion" ? "moved_edges" : "elements"; }

template <class Visitor>
void for_each_curve(const Rows& rows, Visitor&& visit) {
  for (const Rows& of : rows.groups({"table", "scene", "pipeline"}))
    visit(of.value("table"), of.value("scene"), of.value("pipeline"), of);
}

std::string exponent_text(const Fit& f) {
  if (f.points < 2) return "-";
  return f.points == 2 ? fmt::format("{:.2f}", f.exponent) : fmt::format("{:.2f} +- {:.2f}", f.exponent, f.spread);
}

}  // namespace

ExperimentPlan scaling_plan(const PlanContext& context) {
  ExperimentPlan plan{"scaling", context.full ? "full" : "quick", context.full ? kFullRounds : 1, {}};
  for (const TableScene& scene : table_scenes(context)) {
    const bool divided = scene.name == "octopi" || scene.name == "airbag" || scene.name == "crash";
    const bool scaled = scene.name == "octopi" || scene.name == "liver";  // in their motion
    if (!(divided || scaled) || (!context.full && scene.name != "octopi")) continue;
    const std::vector<StepWindow> middle = sampled_windows(step_count(scene.file), 1, 1);
    for (int times = 0; divided && times <= (context.full ? 2 : 1); ++times) {
      // These scenes have no edits. The octopi divided once have 0.14 M tetrahedra, and the crash divided twice has
      // 0.96 M shells, which is the paper's size.
      if (scene.name == "octopi" && times > 1) continue;
      SceneRun run{scene.name, scene.file, table_config(scene.file), middle, {}};
      run.subdivisions = times;
      run.motion_scale = std::pow(0.5, times);
      add_entrants(context, "elements", fmt::format("size={}", times), run);
      plan.runs.push_back(std::move(run));
    }
    if (!scaled) continue;
    const double moved = middle_movement(scene.file, middle[0].first);
    for (const double edges : {0.1, 0.3, 1.0, 3.0, 10.0}) {
      if (!context.full && edges > 1) continue;
      SceneRun run{scene.name, scene.file, table_config(scene.file), middle, {}};
      run.motion_scale = edges / std::max(moved, 1e-12);
      add_entrants(context, "motion", fmt::format("motion={}", edges), run);
      // A step of these would take minutes, because they test all pairs.
      if (edges > 3)
        std::erase_if(run.entrants, [](const Entrant& e) { return e.pipeline == "NavCCD" || e.pipeline == "HashCCD"; });
      plan.runs.push_back(std::move(run));
    }
  }
  return plan;
}

std::vector<TitledTable> scaling_tables(const json& record) {
  const Rows rows(record);
  TextTable points(
      {"table", "scene", "pipeline", "elements", "moved, edges", "ms a step", "workspace", "tests", "contacts"});
  TextTable exponents({"against", "scene", "pipeline", "time", "memory", "tests"});
  for_each_curve(rows, [&](const json& table, const json& scene, const json& pipeline, const Rows& of) {
    for (const Rows& at : of.groups({"variant"})) {
      points.add({table, scene, pipeline, grouped(static_cast<std::uint64_t>(at.median("elements"))),
                  fmt::format("{:.2f}", at.median("moved_edges")), number_text(at.mean_ms(kStepTime)),
                  memory(static_cast<std::size_t>(at.median("workspace_bytes"))),
                  grouped(static_cast<std::uint64_t>(at.tests())),
                  grouped(static_cast<std::uint64_t>(at.sum("contacts")))});
    }
    const auto exponent = [&](const char* y) { return exponent_text(fit(curve(of, x_of(table), y))); };
    exponents.add({table, scene, pipeline, exponent("seconds"), exponent("workspace_bytes"), exponent("tests")});
  });
  return {{"Scaling: points", points, "one step in the middle of the sequence\n"},
          {"Scaling: exponents", exponents, "y = c x^exponent, least squares of logarithms, +- standard error\n"}};
}

json scaling_summary(const json& record) {
  json summary = json::array();
  const Rows rows(record);
  for_each_curve(rows, [&](const json& table, const json& scene, const json& pipeline, const Rows& of) {
    for (const char* y : {"seconds", "workspace_bytes", "tests"}) {
      const Fit f = fit(curve(of, x_of(table), y));
      summary.push_back({{"table", table},
                         {"scene", scene},
                         {"pipeline", pipeline},
                         {"quantity", y},
                         {"exponent", f.exponent},
                         {"spread", f.spread},
                         {"points", f.points}});
    }
  });
  return summary;
}

}  // namespace volccd
