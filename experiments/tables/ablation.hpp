// Which stage gains what: combinations of culling stages on each broad phase, and options of stages.
#pragma once

#include <volccd/experiments/tables/catalog.hpp>

namespace volccd {

/// Table "stages": each subset of element culling, assignment with O-Set, and feature filters on each broad phase, from
/// VolCCD+. Table "options": one option of a stage at a time (axes of CSAT, k, leaf size, refit or rebuild, cell size,
/// assignment, O-Set, filters). With context.pipelines or context.settings, the table "sweep" instead: those pipelines
/// (VolCCD+ if none is named), as they are and with each value of each setting ("csat.axis=face,centroid").
ExperimentPlan ablation_plan(const PlanContext& context);
std::vector<TitledTable> ablation_tables(const nlohmann::json& record);

}  // namespace volccd
