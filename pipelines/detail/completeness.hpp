// Decides whether the tests of a pipeline contain every feature pair. No other code decides this (docs/pipelines.md).
#pragma once

#include <volccd/broadphase/broad_phase.hpp>
#include <volccd/culling/assignment.hpp>

namespace volccd::detail {

/// The element pairs that the broad phase must emit so that their tests, together with those of an orphan source if
/// there is one, contain every feature pair without a common vertex that touches. Throws ConfigError, with the reason,
/// if this holds for no range.
PairRange required_range(const std::string& pipeline, const std::string& assignment_name, const Assignment& assignment,
                         bool has_orphans);

/// Throws ConfigError if a pipeline with a flood has no orphan source, which is required for the steps that the flood
/// does not accept.
void require_orphans_for(const std::string& pipeline, const std::string& flood_name, bool has_orphans);

}  // namespace volccd::detail
