// Coplanarity-based culling against CSAT in whole pipelines (Section 7.2), a table of the experiment `ablation`.
#pragma once

#include <vector>

#include <volccd/experiments/tables/catalog.hpp>
#include <volccd/experiments/tables/rows.hpp>

namespace volccd {

/// The column `table` of its rows.
inline constexpr const char* kCoplanarityTable = "coplanarity";

/// VolCCD with each combination of CSAT on elements or not, and on features nothing, CSAT along the paper's axis,
/// coplanarity, or both. The elementary test is `cubic` without its own axes and without its own coplanarity, so that
/// all tests left pay for a search for roots. `variant` names the combination: "none", "CSAT", "coplanarity" or
/// "coplanarity + CSAT", behind "elements: CSAT, " if elements are culled.
void add_coplanarity(const Registry& registry, std::vector<Entrant>& entrants);

/// Time of a step and of culling, tests left, and nanoseconds of culling a test, over those of CSAT, beside the paper's
/// factors. `rows`: those of the entrants above in one scene; there must be some.
TitledTable coplanarity_table(const Rows& rows, const std::string& title);

}  // namespace volccd
