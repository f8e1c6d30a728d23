// The paper's Tables II and III: elementary tests with no culling, with feature culling, with element and feature
// culling.
#pragma once

#include <volccd/experiments/tables/catalog.hpp>

namespace volccd {

/// Octopi, and the crash with its shells as prisms, with the stages of VolCCD-2011: A without culling, B with feature
/// culling (assignment and O-Set), C with element culling as well.
ExperimentPlan culling_plan(const PlanContext& context);
std::vector<TitledTable> culling_tables(const nlohmann::json& record);

}  // namespace volccd
