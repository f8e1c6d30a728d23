// Broad phases of other libraries with the interface of this project, so that they can be verified, combined and timed
// in the same way.
#pragma once

#include <vector>

#include <volccd/query/roles/broad_phase.hpp>

namespace volccd {

class Registry;

/// Adaptors for the libraries that this build includes (CMake: VOLCCD_PEERS, VOLCCD_WITH_CGAL); may be empty.
///
///   fcl-dynamic-tree        FCL, DynamicAABBTreeCollisionManager
///   bullet-dbvt             Bullet, btDbvt
///   embree-collide          Embree 3, rtcCollide
///   cgal-box-intersection   CGAL, box_self_intersection_d
///
/// Guarantee (conservative): each adaptor emits exactly the same pairs as `kdop-bvh` with k = 6. All use the same swept
/// boxes, in floats rounded outward and widened by half of the separation on each side. The adaptor itself removes
/// adjacent pairs and pairs that the object filter drops, and emits self pairs. A topology edit rebuilds the data
/// structure.
///
/// Bounds and self pairs use the executor. The other libraries run on one thread, except `embree-collide`, which uses
/// as many threads as the executor has workers. Embree allocates memory in steady state; Stage::prepare()'s guarantee
/// of no allocation does not hold for `embree-collide`.
std::vector<StageDescriptor<BroadPhase>> describe_peers();

/// Adds all adaptors to the registry. Throws ConfigError if a name is taken.
void add_peers(Registry& registry);

}  // namespace volccd
