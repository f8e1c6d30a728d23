// What a stage's state has seen of a topology, and the adjacency test that goes with it.
#pragma once

#include <cstdint>
#include <vector>

#include <volccd/mesh/adjacency.hpp>
#include <volccd/mesh/topology.hpp>

namespace volccd {

/// Kept in the state of a stage that must follow a topology. One thread at a time.
class TopologyWatch {
 public:
  enum class News {
    none,
    edited,     ///< touched() tells what
    everything  ///< a fresh state, another topology, or too many edits ago
  };

  /// Compares with the last call and brings adjacency() up to date. No allocation if there is no news. If memory runs
  /// out, it has not been called: adjacency() is as before, and the next call tells the same news.
  News look(const Topology& topology);

  /// After News::edited: the changes since the last call, oldest first; valid until the topology's next edit.
  const std::vector<const TopologyChange*>& changes() const { return changes_; }
  /// After News::edited: slots that were emptied or filled, ascending, each once.
  const std::vector<Index>& touched() const { return touched_; }
  const AdjacencyTest& adjacency() const { return adjacency_; }
  std::size_t bytes() const { return adjacency_.bytes() + touched_.capacity() * sizeof(Index); }

 private:
  std::uint64_t version_ = 0;
  std::vector<Index> touched_;
  std::vector<const TopologyChange*> changes_;
  AdjacencyTest adjacency_;
};

}  // namespace volccd
