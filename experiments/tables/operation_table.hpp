// Section 7.1 as a table: what a CSAT test and an elementary test cost.
#pragma once

#include <volccd/experiments/tables/catalog.hpp>

namespace volccd {

/// operation_counts() on candidates of a middle motion of octopi, drawn alike on every run.
std::vector<nlohmann::json> operation_rows(const PlanContext& context);
std::vector<TitledTable> operation_tables(const nlohmann::json& record);

}  // namespace volccd
