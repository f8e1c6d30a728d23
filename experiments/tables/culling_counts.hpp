// The paper's Tables II and III: elementary tests with no culling, with feature culling, with element and feature
// culling.
#pragma once

#include <volccd/experiments/tables/catalog.hpp>

namespace volccd {

/// Octopi, and the crash with its shells as prisms: A nothing is culled, B features (assignment and O-Set), C elements,
/// too; with the stages of VolCCD-2011.
ExperimentPlan culling_plan(const PlanContext& context);
std::vector<TitledTable> culling_tables(const nlohmann::json& record);

}  // namespace volccd
