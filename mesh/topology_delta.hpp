// What has changed in a topology since a stage's state was last updated.
#pragma once

#include <cstdint>
#include <vector>

#include <volccd/mesh/topology.hpp>

namespace volccd {

/// Kept in the state of a stage that must follow a topology. An update of the state begins with sync() and ends with
/// confirm(). One thread at a time.
class TopologyDelta {
 public:
  enum class Extent {
    none,
    edits,
    everything  ///< the state must be made anew
  };

  /// Compares the topology with the one that confirm() was last called for. `everything` for a fresh state, another
  /// topology, more than Topology::kHistory edits, and after an update that was not confirmed, because an exception was
  /// thrown for example. No allocation if nothing has changed.
  Extent sync(const Topology& topology);
  /// The state agrees with the topology of the last sync().
  void confirm() { confirmed_ = synced_; }

  /// The changes, oldest first, unless everything changed; valid until the topology's next edit.
  const std::vector<const TopologyChange*>& changes() const { return changes_; }
  /// The element slots that they emptied or filled, ascending, each once.
  const std::vector<Index>& changed_slots() const { return changed_slots_; }
  std::size_t bytes() const {
    return changed_slots_.capacity() * sizeof(Index) + changes_.capacity() * sizeof(changes_[0]);
  }

 private:
  std::uint64_t confirmed_ = 0, synced_ = 0;  ///< versions; 0: none
  std::vector<const TopologyChange*> changes_;
  std::vector<Index> changed_slots_;
};

}  // namespace volccd
