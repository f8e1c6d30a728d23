// Whole steps of VolCCD+, compared with VolCCD, with VolCCD+ without the flood, and with VolCCD+ on the boundary alone.
#pragma once

#include <volccd/experiments/tables/catalog.hpp>

namespace volccd {

/// VolCCD and VolCCD+ with `cubic` and with `inclusion`, VolCCD+ without flood, VolCCD+ on the boundary alone with and
/// without flood, and the context's pipelines, on table_scenes(), on a mesh of 105 K tetrahedra that is turned and
/// shortened, and on two surfaces. With `full`, also tentative motion if a file has velocities, and everything on two
/// threads if the machine has two cores (table "2 threads").
ExperimentPlan plus_plan(const PlanContext& context);

/// Tables of times, ratios, counts, and the speed-up of two threads.
std::vector<TitledTable> plus_tables(const nlohmann::json& record);

/// An object for each scene, motion model and number of threads; docs/record.schema.json lists its keys.
nlohmann::json plus_summary(const nlohmann::json& record);

}  // namespace volccd
