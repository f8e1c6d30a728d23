// The changes of a topology since the state of a stage was last updated.
#pragma once

#include <cstdint>
#include <vector>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/mesh/topology.hpp>

namespace volccd {

/// Member of the state of a stage that depends on a topology. An update of the state begins with sync() and ends with
/// confirm(). Not thread-safe.
class TopologyDelta {
 public:
  enum class Extent {
    none,
    edits,
    everything  ///< the state must be rebuilt
  };

  /// Compares the topology with the one of the last confirm(). The result is `everything` for a new state, for another
  /// topology, after more than Topology::kHistory edits, and if the previous update was not confirmed (for example
  /// because of an exception). No allocation if nothing has changed.
  Extent sync(const Topology& topology);
  /// States that the state now agrees with the topology of the last sync().
  void confirm() { confirmed_ = synced_; }

  /// The changes, oldest first; empty if everything changed. Valid until the next edit of the topology.
  const std::vector<const TopologyChange*>& changes() const { return changes_; }
  /// The element slots that these changes emptied or filled, ascending, each once.
  const std::vector<Index>& changed_slots() const { return changed_slots_; }
  std::size_t bytes() const { return heap_bytes(changed_slots_, changes_); }

 private:
  std::uint64_t confirmed_ = 0, synced_ = 0;  ///< versions; 0: none
  std::vector<const TopologyChange*> changes_;
  std::vector<Index> changed_slots_;
};

}  // namespace volccd
