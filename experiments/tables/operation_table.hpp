// Section 7.1 as a table: the cost of a CSAT test and of an elementary test.
#pragma once

#include <volccd/experiments/tables/catalog.hpp>

namespace volccd {

/// operation_counts() on candidates of a motion in the middle of octopi; every run draws the same ones.
std::vector<nlohmann::json> operation_rows(const PlanContext& context);
std::vector<TitledTable> operation_tables(const nlohmann::json& record);

}  // namespace volccd
