// How time, memory and tests grow with elements and with motion.
#pragma once

#include <volccd/experiments/tables/catalog.hpp>

namespace volccd {

/// Table "elements": sequences divided up to twice (SceneRun::subdivisions). Motion goes down with the edge length
/// (half of it a division), so that motion an edge stays as it was: the crash, divided twice and with its motions cut
/// in four, has the paper's size. Table "motion": octopi with the motion scaled to 0.1 to 10 mean edges.
ExperimentPlan scaling_plan(const PlanContext& context);
std::vector<TitledTable> scaling_tables(const nlohmann::json& record);

/// {"table", "scene", "pipeline", "quantity", "exponent", "spread"}: least squares of logarithms, and the standard
/// error.
nlohmann::json scaling_summary(const nlohmann::json& record);

}  // namespace volccd
