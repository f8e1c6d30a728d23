// Which rank owns an id.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <volccd/distributed/exchange.hpp>
#include <volccd/numerics/types.hpp>

namespace volccd::distributed::detail {

inline constexpr int kNoRank = -1;

/// The owner of each of the `asked` ids, kNoRank for one that no rank owns. `owned`: the ids of this rank. If an id is
/// owned twice, all ranks throw a RankError that names it, and both ranks; `what` names the ids in it: "vertex".
/// Collective. Each rank keeps the owners of the ids that a hash gives it, for the time of the call.
std::vector<int> find_owners(Exchange& exchange, const std::string& what, std::span<const std::int64_t> owned,
                             std::span<const std::int64_t> asked);

/// Positions in a list of distinct ids, by id.
class IdTable {
 public:
  IdTable() = default;
  explicit IdTable(std::span<const std::int64_t> ids);

  /// Position of the id, or kNone. O(log(ids)).
  Index find(std::int64_t id) const;

 private:
  std::vector<std::pair<std::int64_t, Index>> entries_;  ///< ascending
};

}  // namespace volccd::distributed::detail
