// The motion of vertices that a rank needs, from the ranks that own them.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <volccd/distributed/detail/owners.hpp>
#include <volccd/distributed/exchange.hpp>
#include <volccd/query/motion.hpp>

namespace volccd::distributed::detail {

class VertexImport {
 public:
  VertexImport() = default;
  /// `wanted`: ids; `owners`: the rank of each, or kNoRank for a vertex that stays at the origin; `own`: positions of
  /// ids in the motion that this rank will give. Collective.
  VertexImport(Exchange& exchange, std::span<const std::int64_t> wanted, std::span<const int> owners,
               const IdTable& own);

  /// The motion of the wanted vertices, in their order; valid until the next call. `own`: of the vertices that this
  /// rank owns. Collective.
  const Motion& update(const Motion& own);
  /// That of the last update.
  const Motion& motion() const { return motion_; }

  /// To which ranks, this one too, the vertices that this rank owns go: positions in its motion, and ranks.
  std::vector<std::pair<Index, int>> receivers() const;
  std::uint64_t bytes_received() const { return bytes_received_; }  ///< by the last update
  std::size_t neighbours() const { return graph_ ? graph_->sources().size() : 0; }

 private:
  int rank_ = 0;                              ///< this one
  std::unique_ptr<Neighbourhood> graph_;      ///< null before it is constructed
  std::vector<std::vector<Index>> sent_;      ///< by destination: positions in the own motion
  std::vector<std::vector<Index>> received_;  ///< by source: positions in the motion of the wanted ones
  std::vector<Index> kept_own_, kept_;        ///< positions of own vertices in both
  Index count_ = 0;
  Motion motion_;
  std::uint64_t bytes_received_ = 0;
};

}  // namespace volccd::distributed::detail
