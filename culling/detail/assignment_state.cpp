#include <volccd/culling/detail/assignment_state.hpp>

#include <vector>

namespace volccd::detail {

void AssignmentState::update(const Topology& topology) {
  if (o_set_) o_set_->update(topology);
  if (version_ == topology.version()) return;
  std::vector<const TopologyChange*> changes;
  if (version_ != 0 && topology.changes_since(version_, changes)) {
    for (const TopologyChange* change : changes) {
      adjacency_.update(topology.mesh(), change->removed_elements);
      adjacency_.update(topology.mesh(), change->added_elements);
    }
  } else {
    adjacency_.build(topology.mesh());
  }
  version_ = topology.version();
}

}  // namespace volccd::detail
