#include <cstdio>
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <volccd/io/stats_json.hpp>
#include <volccd/program/commands.hpp>
#include <volccd/program/report.hpp>

namespace volccd {

namespace {

/// Adds the stages of a role to `list`, and prints them.
template <class Stage>
void add_stages(const Registry& registry, const char* purpose, const Report& report, nlohmann::json& list) {
  report.print("{}: {}\n", Stage::kRole, purpose);
  for (const StageDescriptor<Stage>& stage : registry.stages<Stage>()) {
    report.print(
        "{}", labelled("  " + stage.name, fmt::format("{} [{}]", stage.description, to_string(stage.guarantee)), 23));
    for (const OptionInfo& option : stage.options)
      report.print(
          "{}",
          labelled("    " + stage.name + "." + option.name,
                   fmt::format("{} ({}; default {})", option.description, option.allowed, option.default_value), 31));
    list.push_back({{"name", stage.name},
                    {"role", Stage::kRole},
                    {"guarantee", to_string(stage.guarantee)},
                    {"description", stage.description},
                    {"options", options_json(stage.options)}});
  }
  report.print("\n");
}

std::string text_of(const StageChoice& choice) {
  std::string options;
  for (const auto& [name, value] : choice.options) options += (options.empty() ? "" : ", ") + name + "=" + value;
  return options.empty() ? choice.name : choice.name + "(" + options + ")";
}

std::string text_of(const std::vector<StageChoice>& choices) {
  std::string text;
  for (const StageChoice& choice : choices) text += (text.empty() ? "" : ", ") + text_of(choice);
  return text.empty() ? "none" : text;
}

void add_pipelines(const Registry& registry, const Report& report, nlohmann::json& list) {
  report.print(
      "pipelines (--pipeline): broad phase | element culling | assignment | orphans | flood |\n"
      "feature filters | narrow phase\n");
  for (const PipelineSpec& spec : registry.pipelines()) {
    report.print("{}", labelled("  " + spec.name, spec.description, 23));
    report.print("{}", labelled("",
                                fmt::format("{} | {} | {} | {} | {} | {} | {}", text_of(spec.broad_phase),
                                            text_of(spec.element_culling), text_of(spec.assignment),
                                            spec.orphans ? text_of(*spec.orphans) : "none",
                                            spec.flood ? text_of(*spec.flood) : "none", text_of(spec.feature_filters),
                                            text_of(spec.narrow_phase)),
                                4));
    nlohmann::json entry = to_json(spec);
    entry["description"] = spec.description;
    list.push_back(std::move(entry));
  }
}

int list_stages(const Registry& registry, const ReportOptions& options) {
  const Report report(options);
  nlohmann::json stages = nlohmann::json::array(), pipelines = nlohmann::json::array();
  add_stages<BroadPhase>(registry, "candidate pairs of elements", report, stages);
  add_stages<ElementCulling>(registry, "drops element pairs, masks features of a pair", report, stages);
  add_stages<Assignment>(registry, "chooses the tests of an element pair", report, stages);
  add_stages<OrphanSource>(registry, "gives the tests that no pair of non-adjacent elements contains; may be none",
                           report, stages);
  add_stages<Flood>(registry, "reaches all contacts from pairs of boundary elements; may be none", report, stages);
  add_stages<FeatureFilter>(registry, "drops single tests", report, stages);
  add_stages<NarrowPhase>(registry, "elementary tests", report, stages);
  add_pipelines(registry, report, pipelines);
  report.write("stages", {{"stages", stages}, {"pipelines", pipelines}});
  return kDone;
}

}  // namespace

void add_stages_command(CLI::App& app, const Registry& registry, Action& action) {
  CLI::App* command = app.add_subcommand("stages", "the registered stages and pipelines, with options and guarantees");
  const auto options = std::make_shared<ReportOptions>();
  options->add_to(*command);
  command->footer(
      "Use a stage in place of another:   --set broad-phase=spatial-hash\n"
      "Use several, or none:              --set feature-filter=feature-kdop,coplanarity\n"
      "Set an option of a stage:          --set csat.axis=optimal\n"
      "Example:\n"
      "  volccd stages --json");
  command->callback(
      [options, &registry, &action] { action = [options, &registry] { return list_stages(registry, *options); }; });
}

}  // namespace volccd
