// The inner loop of CSAT, compiled for each instruction set and selected at run time, with the same results on all of
// them.
#pragma once

#include <volccd/culling/csat.hpp>

namespace volccd::detail {

/// The implementation of Csat::run.
void csat_cull(const Csat::Config& config, const Step& step, PairBatch& batch);

}  // namespace volccd::detail
