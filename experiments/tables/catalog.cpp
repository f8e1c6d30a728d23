#include <volccd/experiments/tables/catalog.hpp>

#include <fmt/format.h>

#include <volccd/experiments/tables/ablation.hpp>
#include <volccd/experiments/tables/boundary_table.hpp>
#include <volccd/experiments/tables/culling_counts.hpp>
#include <volccd/experiments/tables/feature_sets.hpp>
#include <volccd/experiments/tables/first_steps.hpp>
#include <volccd/experiments/tables/inversion_table.hpp>
#include <volccd/experiments/tables/operation_table.hpp>
#include <volccd/experiments/tables/peers.hpp>
#include <volccd/experiments/tables/pipelines_table.hpp>
#include <volccd/experiments/tables/plus.hpp>
#include <volccd/experiments/tables/scaling.hpp>
#include <volccd/experiments/tables/substeps.hpp>
#include <volccd/experiments/tables/table1.hpp>
#include <volccd/io/sequence/reader.hpp>

namespace volccd {

const std::vector<ExperimentKind>& experiment_kinds() {
  static const std::vector<ExperimentKind> kinds = {
      {"projectile", "NavCCD, HashCCD, VolCCD and VolCCD+ on a real penetration run: time, counts, shares",
       projectile_plan, pipeline_tables, nullptr, nullptr, true},
      {"table1", "Table I three times: as in 2011, with today's baselines, and certified; Figures 4 and 11",
       table1_plan, table1_tables, table1_summary, nullptr, true},
      {"culling", "Tables II and III: VF and EE tests without culling, with features, with features and elements",
       culling_plan, culling_tables, nullptr},
      {"ablation", "sound combinations of culling stages on each broad phase, and options (--pipelines, --set)",
       ablation_plan, ablation_tables, nullptr, nullptr, true, true},
      {"scaling", "time, memory and tests against elements and against movement per step", scaling_plan, scaling_tables,
       scaling_summary, nullptr, true},
      {"plus", "whole steps of VolCCD+ and VolCCD, without the flood, and on the boundary alone; two cores", plus_plan,
       plus_tables, plus_summary, nullptr, true},
      {"boundary", "Section 7.1: all features against those of the boundary alone, on one thread and on two",
       boundary_plan, boundary_tables, nullptr},
      {"operations", "Section 7: operations and nanoseconds of CSAT, of an elementary test, and of OBBs and k-DOPs",
       operation_plan, operation_tables, nullptr, operation_rows},
      {"inversion", "Section 7.2: contacts within objects that an inversion test points at, and those that it misses",
       inversion_plan, inversion_tables, nullptr, inversion_rows},
      {"peers", "broad phases side by side, those of other libraries included: update, query, pairs a second, memory",
       peers_plan, peers_tables, peers_summary, peers_rows},
      {"substeps", "VolCCD+ on motions divided into 1 to 1000 substeps, with and without candidate lists",
       substeps_plan, substeps_tables, substeps_summary, substeps_rows},
      {"first-steps", "VolCCD+: the first step of a mesh in parts (topology, tree, tables, the rest), beside later steps",
       first_steps_plan, first_steps_tables, first_steps_summary, first_steps_rows},
      {"feature-sets", "Figure 3: the bullet with contacts among all features, the boundary's, and the first surface's",
       feature_set_plan, feature_set_tables, nullptr, feature_set_rows, false, false, true},
  };
  return kinds;
}

std::vector<TableScene> table_scenes(const PlanContext& context) {
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
std::string percent_text(double share) { return fmt::format("{:.3g} %", 100 * share); }

}  // namespace volccd
