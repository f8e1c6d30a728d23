#include <volccd/mesh/topology_delta.hpp>

#include <utility>

#include <volccd/core/sort_unique.hpp>

namespace volccd {

TopologyDelta::Extent TopologyDelta::sync(const Topology& topology) {
  const std::uint64_t last = std::exchange(confirmed_, 0);
  synced_ = topology.version();
  changed_slots_.clear();
  if (!topology.changes_since(last, changes_)) return Extent::everything;
  if (changes_.empty()) return Extent::none;
  for (const TopologyChange* change : changes_)
    for (const auto* slots : {&change->removed_elements, &change->added_elements})
      changed_slots_.insert(changed_slots_.end(), slots->begin(), slots->end());
  sort_unique(changed_slots_);
  return Extent::edits;
}

}  // namespace volccd
