// What only reproduces the measurements of 2011: the paper's stages as scalar code without rounding bounds, and the
// pipelines of its Table I.
#pragma once

namespace volccd {

class Registry;

/// Adds the stages `csat-2011`, `feature-csat-2011` and `provot` (all approximate) and the pipelines `NavCCD-2011`,
/// `HashCCD-2011` and `VolCCD-2011` (docs/pipelines.md), in which nothing of the years after 2011 is; nothing if the
/// registry has them already. Throws ConfigError if another stage or pipeline has one of these names.
void add_paper2011(Registry& registry);

}  // namespace volccd
