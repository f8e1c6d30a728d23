#include <volccd/experiments/tables/catalog.hpp>

#include <fmt/format.h>

#include <volccd/experiments/tables/ablation.hpp>
#include <volccd/experiments/tables/baselines.hpp>
#include <volccd/experiments/tables/boundary_table.hpp>
#include <volccd/experiments/tables/culling_counts.hpp>
#include <volccd/experiments/tables/feature_sets.hpp>
#include <volccd/experiments/tables/first_steps.hpp>
#include <volccd/experiments/tables/inversion_table.hpp>
#include <volccd/experiments/tables/operation_table.hpp>
#include <volccd/experiments/tables/peers.hpp>
#include <volccd/experiments/tables/pipelines_table.hpp>
#include <volccd/experiments/tables/plus.hpp>
#include <volccd/experiments/tables/ranks.hpp>
#include <volccd/experiments/tables/scaling.hpp>
#include <volccd/experiments/tables/substeps.hpp>
#include <volccd/experiments/tables/table1.hpp>
#include <volccd/io/sequence/reader.hpp>

namespace volccd {

const std::vector<ExperimentKind>& experiment_kinds() {
  static const std::vector<ExperimentKind> kinds = {
      {.name = "projectile",
       .description = "NavCCD, HashCCD, VolCCD and VolCCD+ on a real penetration run: time, counts, shares",
       .plan = projectile_plan,
       .tables = pipeline_tables,
       .takes_pipelines = true,
       .takes_scenes = true},
      {.name = "table1",
       .description = "Table I three times: as in 2011, with today's baselines, and certified; Figures 4 and 11",
       .plan = table1_plan,
       .tables = table1_tables,
       .summary = table1_summary,
       .takes_pipelines = true,
       .takes_scenes = true},
      {.name = "baselines",
       .description = "Table I-d: VolCCD+ and VolCCD beside the strongest baselines, and what each theorem gives",
       .plan = baselines_plan,
       .tables = baselines_tables,
       .summary = baselines_summary,
       .takes_pipelines = true,
       .takes_scenes = true},
      {.name = "culling",
       .description = "Tables II and III: VF and EE tests without culling, with features, with features and elements",
       .plan = culling_plan,
       .tables = culling_tables},
      {.name = "ablation",
       .description = "sound combinations of culling stages on each broad phase, and options (--pipelines, --set)",
       .plan = ablation_plan,
       .tables = ablation_tables,
       .takes_pipelines = true,
       .takes_settings = true,
       .takes_scenes = true},
      {.name = "scaling",
       .description = "time, memory and tests against elements and against movement per step",
       .plan = scaling_plan,
       .tables = scaling_tables,
       .summary = scaling_summary,
       .takes_pipelines = true},
      {.name = "plus",
       .description = "whole steps of VolCCD+ and VolCCD, without the flood, and on the boundary alone; two cores",
       .plan = plus_plan,
       .tables = plus_tables,
       .summary = plus_summary,
       .takes_pipelines = true,
       .takes_scenes = true},
      {.name = "boundary",
       .description = "Section 7.1: all features against those of the boundary alone, on one thread and on two",
       .plan = boundary_plan,
       .tables = boundary_tables,
       .takes_scenes = true},
      {.name = "operations",
       .description = "Section 7: operations and nanoseconds of CSAT, of an elementary test, and of OBBs and k-DOPs",
       .plan = operation_plan,
       .tables = operation_tables,
       .rows = operation_rows},
      {.name = "inversion",
       .description = "Section 7.2: contacts within objects that an inversion test points at, and those that it misses",
       .plan = inversion_plan,
       .tables = inversion_tables,
       .rows = inversion_rows},
      {.name = "peers",
       .description =
           "broad phases side by side, those of other libraries included: update, query, pairs a second, memory",
       .plan = peers_plan,
       .tables = peers_tables,
       .summary = peers_summary,
       .rows = peers_rows},
      {.name = "substeps",
       .description = "VolCCD+ on motions divided into 1 to 1000 substeps, with and without candidate lists",
       .plan = substeps_plan,
       .tables = substeps_tables,
       .summary = substeps_summary,
       .rows = substeps_rows},
      {.name = "first-steps",
       .description = "VolCCD+: the parts of the first step of a mesh (topology, tree, tables), beside later steps",
       .plan = first_steps_plan,
       .tables = first_steps_tables,
       .summary = first_steps_summary,
       .rows = first_steps_rows},
      {.name = "ranks",
       .description = "VolCCD+ divided among 2 to 512 ranks in one process: slowest rank, copies, bytes; a model",
       .plan = ranks_plan,
       .tables = ranks_tables,
       .summary = ranks_summary,
       .rows = ranks_rows,
       .takes_scenes = true},
      {.name = "feature-sets",
       .description = "Figure 3: the bullet with contacts among all features, the boundary's, and the first surface's",
       .plan = feature_set_plan,
       .tables = feature_set_tables,
       .rows = feature_set_rows,
       .curves = true},
  };
  return kinds;
}

std::vector<TableScene> table_scenes(const PlanContext& context) {
  if (!context.own_scenes.empty()) return context.own_scenes;
  std::vector<TableScene> scenes;
  const auto add = [&](const std::string& name, const std::string& source) {
    if (const std::optional<std::string> file = context.file_of(source)) scenes.push_back({name, *file});
  };
  for (const std::string name : {"octopi", "bullet", "airbag", "liver", "crash"})
    add(name, name + (context.full ? "" : "-quick"));
  for (const char* name : {"ls-dyna-projectile", "openradioss-bullet", "openradioss-airbag", "openradioss-crash"})
    if (context.full || std::string(name) == "ls-dyna-projectile") add(name, name);
  return scenes;
}

std::vector<TableScene> table_and_large_scenes(const PlanContext& context) {
  if (!context.own_scenes.empty()) return context.own_scenes;
  std::vector<TableScene> scenes = table_scenes(context);
  for (const char* name : {"octopus2-105k-deformed", "cloth-ball", "rod-twist"})
    if (const std::optional<std::string> file = context.file_of(name)) scenes.push_back({name, *file, true});
  return scenes;
}

SequenceStepper::Config table_config(const std::string& file, MotionModel motion) {
  SequenceStepper::Config config;
  if (SequenceReader(file).has_thickness()) config.shells = ShellModel::solid;
  config.motion = motion;
  return config;
}

int step_count(const std::string& file) { return SequenceReader(file).frame_count() - 1; }

std::vector<StepWindow> sampled_windows(const std::string& file, int count, int length) {
  const SequenceReader reader(file);
  std::vector<int> edits;  // step k has the cells of frame k + 1
  for (int k = 1; k + 1 < reader.frame_count(); ++k)
    if (!reader.same_cells(k, k + 1)) edits.push_back(k);
  const int steps = reader.frame_count() - 1;
  return with_an_edit(sampled_windows(steps, count, length), steps, edits);
}

std::vector<StepWindow> table_windows(const PlanContext& context, const std::string& file) {
  return context.full ? sampled_windows(file, 4, 3) : sampled_windows(file, 1, 1);
}

Entrant entrant(const Registry& registry, const std::string& table, const std::string& pipeline,
                const std::vector<std::string>& settings) {
  Entrant result{table, pipeline, {}, registry.pipeline(pipeline)};
  for (const std::string& setting : settings) {
    registry.apply_setting(result.spec, setting);
    result.variant += (result.variant.empty() ? "" : " ") + setting;
  }
  result.spec = registry.resolved(result.spec);
  return result;
}

std::string ratio_text(double value) {
  return value >= 100 ? fmt::format("{:.0f}x", value) : fmt::format("{:.3g}x", value);
}
std::string percent_text(double share) { return number_text(100 * share) + " %"; }

}  // namespace volccd
