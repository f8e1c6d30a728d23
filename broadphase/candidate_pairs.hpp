// The pairs of a broad phase by itself, outside of a pipeline.
#pragma once

#include <span>
#include <vector>

#include <volccd/core/function_ref.hpp>
#include <volccd/query/roles/broad_phase.hpp>

namespace volccd {

/// Calls `visit` with the pairs of each block of the step of the last prepare(), on the workers of the executor, which
/// are at the same time in different calls. Pre: prepare() was called with this step and this executor.
void visit_candidates(const BroadPhase& broad_phase, const Step& step, StageState& state, Executor& executor,
                      FunctionRef<void(std::span<const ElementPair> pairs, unsigned worker)> visit);

/// All pairs of the step, ascending.
std::vector<ElementPair> candidate_pairs(const BroadPhase& broad_phase, const Step& step, StageState& state,
                                         Executor& executor);

}  // namespace volccd
