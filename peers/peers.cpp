#include <volccd/peers/peers.hpp>

#include <utility>

#include <volccd/peers/detail/peer_phase.hpp>
#include <volccd/pipelines/registry.hpp>

namespace volccd {

std::vector<StageDescriptor<BroadPhase>> describe_peers() {
  std::vector<StageDescriptor<BroadPhase>> peers;
#ifdef VOLCCD_PEER_FCL
  peers.push_back(detail::describe_fcl_dynamic_tree());
#endif
#ifdef VOLCCD_PEER_BULLET
  peers.push_back(detail::describe_bullet_dbvt());
#endif
#ifdef VOLCCD_PEER_EMBREE
  peers.push_back(detail::describe_embree_collide());
#endif
#ifdef VOLCCD_PEER_CGAL
  peers.push_back(detail::describe_cgal_box_intersection());
#endif
  return peers;
}

void add_peers(Registry& registry) {
  for (StageDescriptor<BroadPhase>& peer : describe_peers()) registry.add(std::move(peer));
}

}  // namespace volccd
