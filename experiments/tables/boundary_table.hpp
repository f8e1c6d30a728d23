// All features against those of the boundary alone (Section 7.1, "surface-based vs. volume-based").
#pragma once

#include <volccd/experiments/tables/catalog.hpp>

namespace volccd {

/// VolCCD-2011, VolCCD and VolCCD+, each on the whole mesh and on its boundary (harness/boundary_shells.hpp), on one
/// thread and on two: the five simulated scenes, and the bullet simulated with fewer features.
ExperimentPlan boundary_plan(const PlanContext& context);
std::vector<TitledTable> boundary_tables(const nlohmann::json& record);

}  // namespace volccd
