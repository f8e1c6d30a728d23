// Steps of VolCCD+ divided among ranks.
#pragma once

#include <volccd/experiments/tables/catalog.hpp>

namespace volccd {

/// The scenes, for their files only (the plan has no windows), and the number of rounds.
ExperimentPlan ranks_plan(const PlanContext& context);

/// One row for each scene, division, motion, number of ranks and round: ranks of one process, one after another
/// (distributed::InProcessDetector), beside one detector for the whole mesh; docs/record.schema.json lists the columns.
/// Throws ConfigError if no scene is available, or if contacts of ranks are not those of the whole mesh.
void ranks_rows(const PlanContext& context, RecordFile& record);

std::vector<TitledTable> ranks_tables(const nlohmann::json& record);

/// An object for each scene, division, motion and number of ranks; docs/record.schema.json lists its keys.
nlohmann::json ranks_summary(const nlohmann::json& record);

}  // namespace volccd
