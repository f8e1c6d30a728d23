// The flood strategy: finds the relevant element pairs from pairs of boundary elements (docs/boundary_flood.md).
#pragma once

#include <cstddef>
#include <vector>

#include <volccd/culling/assignment.hpp>

namespace volccd {

/// A pipeline with a flood searches for pairs in a simplicial complex of the mesh. Broad phase, element culling and
/// assignment receive the step that the flood provides (Flood::step): its topology is that of the complex. Its subset,
/// which only the broad phase receives, contains the parts of elements to be paired. These pairs pass through culling
/// and assignment as whole elements, and those that survive are given to reach(). next() then proposes other pairs,
/// which take the same way, until it proposes none. The flood lists the orphans itself; the OrphanSource is not used.
///
/// Guarantee (conservative): for each feature pair {a,b} that touches, the pairs proposed for the whole step contain
/// every pair of non-adjacent simplices that covers it, and the orphans contain {a,b} if there is no such pair of
/// simplices. This holds for all element culling and broad-phase stages that are conservative.
///
/// A flood may decline a step (takes()) for which it would be slow or is not proven; then the other stages process it.
class Flood : public Stage {
 public:
  static constexpr const char* kRole = "flood";

  /// Whether the flood processes the step of the last prepare(). If not, no member below is called, and the pipeline
  /// runs as if it had no flood. `overlaps`: whether initial overlaps of elements are requested.
  virtual bool takes(const StageState& state, bool overlaps) const = 0;

  /// The step for the broad phase and, without its subset, for culling and assignment. It refers to `state` and is valid
  /// until the next prepare().
  virtual Step step(const StageState& state) const = 0;

  /// Records pairs that survived culling, on the worker that culled them. Also called for pairs that were removed as
  /// PairVerdict::contact_free, which may have points in common.
  virtual void reach(StageState& state, unsigned worker, const std::vector<ElementPair>& pairs) const = 0;

  /// The pairs to process next; if there are none, the flood has ended.
  struct Front {
    std::span<const ElementPair> pairs;
    /// Only pairs that touch at t = 0 are to be given to reach(): culling uses t_max = 0, and no tests are assigned.
    /// All other fronts together contain no pair twice.
    bool at_start = false;
    /// The flood gives up the step because it would process too many pairs. The step is then left to the other stages,
    /// and no other member is called.
    bool given_up = false;
  };
  /// Called on one thread: first when the broad phase has finished, then each time all pairs of the last front are
  /// processed.
  virtual Front next(StageState& state, Executor& executor) const = 0;

  /// Replaces features of the complex by features of the mesh, in all tests from these positions on.
  virtual void to_mesh_features(const StageState& state, TestBatch& tests, std::size_t vf_begin,
                                std::size_t ee_begin) const = 0;

  /// The orphans, in blocks as for OrphanSource::blocks() and run(), as features of the mesh.
  virtual std::size_t orphan_blocks(const StageState& state) const = 0;
  virtual void orphans(const StageState& state, std::size_t block, TestBatch& out) const = 0;
};

}  // namespace volccd
