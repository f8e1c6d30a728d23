// Motions divided into substeps: steps of VolCCD+ with candidate lists, compared with fresh steps.
#pragma once

#include <volccd/experiments/tables/catalog.hpp>

namespace volccd {

/// The scenes, for their files only (the plan has no windows), and the number of rounds.
ExperimentPlan substeps_plan(const PlanContext& context);

/// One row for each scene, number of substeps, motion and round; docs/record.schema.json lists the columns. Throws
/// ConfigError if no scene is available, and Error if steps with lists find other contacts than fresh steps.
void substeps_rows(const PlanContext& context, RecordFile& record);

/// Tables of times, and of what the lists were used for.
std::vector<TitledTable> substeps_tables(const nlohmann::json& record);

/// An object for each scene and number of substeps; docs/record.schema.json lists its keys.
nlohmann::json substeps_summary(const nlohmann::json& record);

}  // namespace volccd
