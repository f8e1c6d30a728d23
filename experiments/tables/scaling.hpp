// Growth of time, memory and tests with the number of elements and with the movement per step.
#pragma once

#include <volccd/experiments/tables/catalog.hpp>

namespace volccd {

/// Table "elements": sequences divided up to twice (SceneRun::subdivisions). Motions are shortened with the edge length
/// (halved at each division), so that the motion relative to the edge length stays the same. The crash, divided twice
/// and with its motion shortened to a quarter, has the paper's size. Table "motion": octopi with the motion scaled to
/// 0.1 to 10 mean edges.
ExperimentPlan scaling_plan(const PlanContext& context);
std::vector<TitledTable> scaling_tables(const nlohmann::json& record);

/// {"table", "scene", "pipeline", "quantity", "exponent", "spread"}: least squares of logarithms, and the standard
/// error.
nlohmann::json scaling_summary(const nlohmann::json& record);

}  // namespace volccd
