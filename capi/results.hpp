// The results of a step as the arrays of the C interface.
#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include <volccd/capi/volccd.h>
#include <volccd/pipelines/pipeline.hpp>

namespace volccd::capi {

struct Results {
  std::vector<volccd_contact> contacts;
  std::vector<volccd_contact_end> ends;
  std::vector<std::int64_t> initial_overlaps;  ///< ids, two for each pair
  std::vector<volccd_statistic> statistics;
  std::deque<std::string> names;  ///< of stages in `statistics`, which has pointers to them
};

volccd_contact contact_of(const Contact& contact, const Mesh& mesh);

/// Replaces `out` by the results of a step on this mesh, whose slots the result has. Memory of `out` is reused.
void fill(Results& out, const StepResult& result, const Mesh& mesh);
void clear(Results& out) noexcept;

}  // namespace volccd::capi
