// The flood strategy: reaches the element pairs that matter from pairs of boundary elements (docs/boundary_flood.md).
#pragma once

#include <cstddef>
#include <vector>

#include <volccd/culling/assignment.hpp>

namespace volccd {

/// A pipeline with a flood looks for pairs on a simplicial complex of the mesh: broad phase, element culling and
/// assignment see the step that the flood gives them (Flood::step), whose topology is that of the complex and whose
/// subset are the elements that the broad phase pairs. What survives culling is handed to reach(); next() proposes
/// further pairs, which go through culling and assignment in their turn, until there are none. The O-Set source is not
/// asked: orphans come from here.
///
/// Guarantee (conservative): the pairs that survive contain, for each feature pair {a,b} that touches, every pair of
/// non-adjacent simplices that covers it; and the orphans contain {a,b} if no such pair does. That holds for any
/// element culling and any broad phase that are conservative themselves.
///
/// A flood may leave a step to the pipeline's other stages (takes()), where it would not pay or is not proven.
class Flood : public Stage {
 public:
  static constexpr const char* kRole = "flood";

  /// Whether the step of the last prepare() is to be flooded. If not, nothing below is called, and the pipeline runs as
  /// if it had no flood. `overlaps`: initial overlaps of elements are asked for.
  virtual bool takes(const StageState& state, bool overlaps) const = 0;

  /// What broad phase, culling and assignment see. Refers to `state`, which keeps it until the next prepare().
  virtual Step step(const StageState& state) const = 0;

  /// Takes note of pairs that survived culling, on the worker that culled them: also those that were taken out as
  /// PairVerdict::contact_free, which may have points in common.
  virtual void reach(StageState& state, unsigned worker, const std::vector<ElementPair>& pairs) const = 0;

  /// Pairs to look at next; none: the flood is over.
  struct Front {
    std::span<const ElementPair> pairs;
    /// Only what touches at t = 0 is to be handed to reach(): culling sees t_max = 0, and no tests are assigned. Other
    /// fronts together hold no pair twice, and none that the broad phase gives.
    bool at_start = false;
    /// The flood leaves the step to the other stages after all: it would look at too many pairs. Nothing else is called
    /// then.
    bool given_up = false;
  };
  /// Called on one thread, first when the broad phase is done, then when all pairs of the last front are.
  virtual Front next(StageState& state, Executor& executor) const = 0;

  /// Puts the features of the mesh in the place of those of the complex, in tests behind these places.
  virtual void to_mesh_features(const StageState& state, TestBatch& tests, std::size_t vf_begin,
                                std::size_t ee_begin) const = 0;

  /// The orphans, as OrphanSource::blocks() and run() give them, in features of the mesh.
  virtual std::size_t orphan_blocks(const StageState& state) const = 0;
  virtual void orphans(const StageState& state, std::size_t block, TestBatch& out) const = 0;
};

}  // namespace volccd
