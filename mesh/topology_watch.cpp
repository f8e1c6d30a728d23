#include <volccd/mesh/topology_watch.hpp>

#include <algorithm>

namespace volccd {

TopologyWatch::News TopologyWatch::look(const Topology& topology) {
  const std::uint64_t seen = version_;
  if (seen == topology.version()) return News::none;
  touched_.clear();
  News news = News::everything;
  if (seen != 0 && topology.changes_since(seen, changes_)) {
    for (const TopologyChange* change : changes_) {
      touched_.insert(touched_.end(), change->removed_elements.begin(), change->removed_elements.end());
      touched_.insert(touched_.end(), change->added_elements.begin(), change->added_elements.end());
    }
    std::sort(touched_.begin(), touched_.end());
    touched_.erase(std::unique(touched_.begin(), touched_.end()), touched_.end());
    adjacency_.update(topology.mesh(), touched_);
    news = News::edited;
  } else {
    adjacency_.build(topology.mesh());
  }
  version_ = topology.version();
  return news;
}

}  // namespace volccd
