// Broad phases side by side: the project's own and those of other libraries that the build has.
#pragma once

#include <volccd/experiments/tables/catalog.hpp>

namespace volccd {

/// The scenes, for their files only (the plan has no windows), and the number of rounds.
ExperimentPlan peers_plan(const PlanContext& context);

/// Times and counts of broad phases on single steps, interleaved: docs/reproducing.md. Throws ConfigError if no scene
/// is available, and Error if two broad phases with the same boxes emit different numbers of pairs.
void peers_rows(const PlanContext& context, RecordFile& record);
std::vector<TitledTable> peers_tables(const nlohmann::json& record);
nlohmann::json peers_summary(const nlohmann::json& record);

}  // namespace volccd
