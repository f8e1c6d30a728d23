// The inner loop of CSAT, compiled for each instruction set and picked at run time; the same results on all of them.
#pragma once

#include <volccd/culling/csat.hpp>

namespace volccd::detail {

/// What Csat::run does.
void csat_cull(const Csat::Config& config, const Step& step, PairBatch& batch);

}  // namespace volccd::detail
