// The flood strategy: finds the relevant element pairs from pairs of boundary elements (docs/boundary_flood.md).
#pragma once

#include <cstddef>
#include <memory>

#include <volccd/query/roles/broad_phase.hpp>
#include <volccd/query/work_source.hpp>

namespace volccd {

/// In the steps that it takes, a flood stands in place of the broad phase and the orphan source. It works on a
/// simplicial complex of the mesh: the pairs that it hands out are pairs of simplices, and element culling and
/// assignment run on its step, whose topology is that of the complex. It hands out further pairs from those that
/// survive, round by round, and at last the orphans, as features of the mesh.
///
/// Guarantee (conservative): for each feature pair {a,b} that touches, the pairs of RoundKind::pairs contain, each
/// once, every pair of non-adjacent simplices that covers it, and the orphans contain {a,b} if there is no such pair of
/// simplices. This holds for all element-culling and broad-phase stages that are conservative.
class Flood : public WorkSource {
 public:
  static constexpr const char* kRole = "flood";

  /// Creates a state that pairs elements with this broad phase, which must outlive it. (A state of make_state()
  /// has none and must not be used.)
  virtual std::unique_ptr<StageState> make_state_with(const BroadPhase& broad_phase) const = 0;

  /// Whether the flood takes the step of the last prepare(), for which it may be too slow, or not proven. If not, no
  /// other member is called, and the other sources process the step. `overlaps`: whether initial overlaps of elements
  /// are requested.
  virtual bool takes(const StageState& state, bool overlaps) const = 0;

  /// The step for element culling and assignment. It refers to `state` and is valid until the next prepare().
  virtual const Step& step(const StageState& state) const = 0;

  /// Replaces features of the complex by features of the mesh, in all tests from these positions on.
  virtual void to_mesh_features(const StageState& state, TestBatch& tests, std::size_t vf_begin,
                                std::size_t ee_begin) const = 0;
};

}  // namespace volccd
