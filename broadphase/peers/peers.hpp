// Broad phases of other libraries behind the project's interface: verified, ablated and timed like its own.
#pragma once

#include <vector>

#include <volccd/broadphase/broad_phase.hpp>

namespace volccd {

class Registry;

/// Adaptors of the libraries that this build has (CMake: VOLCCD_PEERS, VOLCCD_WITH_CGAL); may be empty.
///
///   fcl-dynamic-tree        FCL, DynamicAABBTreeCollisionManager
///   bullet-dbvt             Bullet, btDbvt
///   embree-collide          Embree 3, rtcCollide
///   cgal-box-intersection   CGAL, box_self_intersection_d
///
/// Guarantee (conservative): each emits exactly the pairs that `kdop-bvh` with k = 6 emits. All take the same swept
/// boxes, in floats rounded outward and widened by half of the separation on each side; adjacent pairs, pairs that the
/// object filter drops, and pairs of an element with itself are dealt with by the adaptor. A topology edit builds anew.
///
/// Bounds and self pairs use the executor. The peers themselves run on one thread, but for `embree-collide`, which
/// takes as many threads as the executor has workers. Embree allocates in steady state: that promise of
/// Stage::prepare() does not hold for `embree-collide`.
std::vector<StageDescriptor<BroadPhase>> describe_peers();

/// Adds them all. Throws ConfigError if a name is taken.
void add_peers(Registry& registry);

}  // namespace volccd
