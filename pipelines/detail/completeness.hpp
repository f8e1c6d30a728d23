// Whether the tests of a pipeline contain every feature pair: decided here and nowhere else (docs/pipelines.md).
#pragma once

#include <volccd/broadphase/broad_phase.hpp>
#include <volccd/culling/assignment.hpp>

namespace volccd::detail {

/// Which element pairs the broad phase has to emit, so that their tests, and those of an orphan source if there is one,
/// contain every feature pair without a common vertex that touches. Throws ConfigError if no range does, with the
/// reason.
PairRange required_range(const std::string& pipeline, const std::string& assignment_name, const Assignment& assignment,
                         bool has_orphans);

/// Throws ConfigError unless the pipeline of a flood has orphans: for the steps that the flood does not take.
void require_orphans_for(const std::string& pipeline, const std::string& flood_name, bool has_orphans);

}  // namespace volccd::detail
