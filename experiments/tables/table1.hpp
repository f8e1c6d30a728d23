// The paper's Table I, three times, and its Figures 4 and 11, from one record.
#pragma once

#include <volccd/experiments/tables/catalog.hpp>

namespace volccd {

/// Tables "a" (as in 2011), "b" (today's baselines with the paper's elementary test) and "c" (certified), on
/// table_scenes(), with evenly sampled steps. Table b is also measured with the paper's edge set on scenes of
/// hexahedra, and table c on tentative motion if the file has velocities, and on query motion if it has queries. The
/// pipelines of a scene run interleaved.
ExperimentPlan table1_plan(const PlanContext& context);

std::vector<TitledTable> table1_tables(const nlohmann::json& record);

/// For each table, scene, motion model and edge set: {"table", "scene", "motion_model", "edges", "elements", "steps",
/// "navccd_ms", "hashccd_ms", "volccd_ms", "volccd_plus_ms" (c), "speedup_navccd", "speedup_hashccd": of volccd_ms,
/// with
/// "_plus" behind them of volccd_plus_ms, "culling_ratio_percent"}. Milliseconds are means over steps (the paper's
/// average) of medians over rounds, the topology's edits included.
nlohmann::json table1_summary(const nlohmann::json& record);

}  // namespace volccd
