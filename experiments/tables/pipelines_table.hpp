// Comparison of pipelines on one sequence, with the time of each stage.
#pragma once

#include <volccd/experiments/tables/catalog.hpp>

namespace volccd {

/// NavCCD, HashCCD, VolCCD and VolCCD+ with the paper's elementary test, and the context's pipelines, on all steps of
/// the LS-DYNA run, or of the built-in scene if that run is not available.
ExperimentPlan projectile_plan(const PlanContext& context);

/// For each scene two tables: time for each step, speed-up, pairs, tests and contacts; and the share of each stage in
/// the time.
std::vector<TitledTable> pipeline_tables(const nlohmann::json& record);

}  // namespace volccd
