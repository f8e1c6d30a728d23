// Table I-d: the strongest baselines, and what each of the two theorems gives.
#pragma once

#include <volccd/experiments/tables/catalog.hpp>

namespace volccd {

/// On table_scenes(), with certified elementary tests and the same contacts:
/// - baselines: NavCCD; NavCCD without adjacent pairs (the O-Set has the tests that only these contain), alone, with
///   feature filters, and with the broad phases of Embree and CGAL where the program has them; VolCCD+ with neither of
///   its theorems, which is the paper's culling with today's filters;
/// - VolCCD; VolCCD+ with one of its theorems, the boundary flood or clear stars; VolCCD+; the context's pipelines.
/// A full run also has the simulated scenes at their small size with three seeds, for some of these.
ExperimentPlan baselines_plan(const PlanContext& context);

/// Tables of times, of ratios with their intervals, of the theorems, of steps with contacts and without, of first
/// steps, and of the seeds.
std::vector<TitledTable> baselines_tables(const nlohmann::json& record);

/// An object for each scene, without those with several seeds; docs/record.schema.json lists its keys.
nlohmann::json baselines_summary(const nlohmann::json& record);

}  // namespace volccd
