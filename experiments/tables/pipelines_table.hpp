// Pipelines side by side on one sequence, and where their time goes.
#pragma once

#include <volccd/experiments/tables/catalog.hpp>

namespace volccd {

/// NavCCD, HashCCD, VolCCD and VolCCD+ with the paper's elementary test, and the context's pipelines, on all motions of
/// the LS-DYNA run, or of the built-in scene where that is not there.
ExperimentPlan projectile_plan(const PlanContext& context);

/// Time a step, speed-up, pairs, tests, contacts; and shares of the time by stage. One pair of tables for each scene.
std::vector<TitledTable> pipeline_tables(const nlohmann::json& record);

}  // namespace volccd
