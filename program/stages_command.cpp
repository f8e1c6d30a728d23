#include <cstdio>

#include <fmt/format.h>

#include <volccd/program/commands.hpp>

namespace volccd {

namespace {

template <class Stage>
void print_stages(const Registry& registry, const char* purpose) {
  fmt::print("{}: {}\n", Stage::kRole, purpose);
  for (const StageDescriptor<Stage>& stage : registry.stages<Stage>()) {
    fmt::print("  {:<20} {} [{}]\n", stage.name, stage.description, to_string(stage.guarantee));
    for (const OptionInfo& option : stage.options)
      fmt::print("    {:<22} {} ({}; default {})\n", stage.name + "." + option.name, option.description, option.allowed,
                 option.default_value);
  }
  fmt::print("\n");
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

void print_pipelines(const Registry& registry) {
  fmt::print("pipelines (--pipeline)\n");
  for (const PipelineSpec& spec : registry.pipelines()) {
    fmt::print("  {:<20} {}\n", spec.name, spec.description);
    fmt::print("    {} | {} | {} | {} | {} | {} | {}\n", text_of(spec.broad_phase), text_of(spec.element_culling),
               text_of(spec.assignment), spec.orphans ? text_of(*spec.orphans) : "none",
               spec.flood ? text_of(*spec.flood) : "none", text_of(spec.feature_filters),
               text_of(spec.narrow_phase));
  }
}

}  // namespace

void add_stages_command(CLI::App& app, const Registry& registry, Action& action) {
  CLI::App* command = app.add_subcommand("stages", "what is registered, with options and guarantees");
  command->footer(
      "Use a stage in place of another:   --set broad-phase=spatial-hash   "
      "--set feature-filter=feature-kdop,coplanarity\n"
      "Set an option of a stage:          --set csat.axis=optimal");
  command->callback([&registry, &action] {
    action = [&registry] {
      print_stages<BroadPhase>(registry, "candidate pairs of elements");
      print_stages<ElementCulling>(registry, "drops element pairs, masks features of a pair");
      print_stages<Assignment>(registry, "which tests an element pair performs");
      print_stages<OrphanSource>(registry, "tests that no pair of non-adjacent elements covers; may be none");
      print_stages<Flood>(registry, "reaches all contacts from pairs of boundary elements; may be none");
      print_stages<FeatureFilter>(registry, "drops single tests");
      print_stages<NarrowPhase>(registry, "elementary tests");
      print_pipelines(registry);
      return kDone;
    };
  });
}

}  // namespace volccd
