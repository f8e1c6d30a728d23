// The gain of each stage: combinations of culling stages with each broad phase, and options of stages.
#pragma once

#include <volccd/experiments/tables/catalog.hpp>

namespace volccd {

/// Table "stages": each subset of element culling, assignment (with the O-Set or with star orphans), feature filters
/// and flood on each broad phase, from VolCCD+. Table "options": one option of a stage at a time (axes of CSAT, k, leaf
/// size, refit or rebuild, cell size, assignment, O-Set, filters). Table "coplanarity": coplanarity_table.hpp. If
/// context.pipelines or context.settings is given, there is only the table "sweep": those pipelines (VolCCD+ if none is
/// named), unchanged and with each value of each setting ("csat.axis=face,centroid").
ExperimentPlan ablation_plan(const PlanContext& context);
std::vector<TitledTable> ablation_tables(const nlohmann::json& record);

}  // namespace volccd
