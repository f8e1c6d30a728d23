// Section 7 as tables: the cost of a CSAT test and of an elementary test (7.1), and of OBBs and k-DOPs (7.2).
#pragma once

#include <volccd/experiments/tables/catalog.hpp>

namespace volccd {

/// octopi, for its input only: the plan has no windows.
ExperimentPlan operation_plan(const PlanContext& context);

/// operation_counts() on candidates of a step in the middle of octopi, and bound_operation_counts() on its elements;
/// every run draws the same ones.
void operation_rows(const PlanContext& context, RecordFile& record);
std::vector<TitledTable> operation_tables(const nlohmann::json& record);

}  // namespace volccd
