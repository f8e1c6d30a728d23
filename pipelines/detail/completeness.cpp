#include <volccd/pipelines/detail/completeness.hpp>

#include <fmt/format.h>

namespace volccd::detail {

PairRange required_range(const std::string& pipeline, const std::string& assignment_name, const Assignment& assignment,
                         bool has_orphans) {
  const std::string reason = has_orphans ? assignment.incomplete_on_nonadjacent() : assignment.incomplete_on_every();
  if (!reason.empty())
    throw ConfigError(fmt::format("pipeline {}: {} would lose contacts: {}", pipeline, assignment_name, reason));
  return has_orphans ? PairRange::nonadjacent : PairRange::every;
}

void require_orphans_for(const std::string& pipeline, const std::string& flood_name, bool has_orphans) {
  if (has_orphans) return;
  throw ConfigError(
      fmt::format("pipeline {}: {} needs an assignment and an O-Set for the steps that it does not take; use "
                  "orphans=o-set, or flood=none",
                  pipeline, flood_name));
}

}  // namespace volccd::detail
