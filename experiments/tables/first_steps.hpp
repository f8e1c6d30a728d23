// What the first step of a mesh costs, beside later ones.
#pragma once

#include <volccd/experiments/tables/catalog.hpp>

namespace volccd {

/// The scenes, for their files only (the plan has no windows), and the number of rounds.
ExperimentPlan first_steps_plan(const PlanContext& context);

/// One row for each scene and round; docs/record.schema.json lists the columns. Throws ConfigError if no scene is
/// available.
void first_steps_rows(const PlanContext& context, RecordFile& record);

std::vector<TitledTable> first_steps_tables(const nlohmann::json& record);

/// An object for each scene; docs/record.schema.json lists its keys.
nlohmann::json first_steps_summary(const nlohmann::json& record);

}  // namespace volccd
