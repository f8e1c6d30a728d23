// The element-culling strategy: drops element pairs that cannot touch during the step, or masks features that cannot
// touch the other element of a pair.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/query/pairs.hpp>
#include <volccd/query/stage.hpp>

namespace volccd {

/// Features of an element pair (a,b) that are proven not to touch the other element. Bit i of `vertices_a`: vertex i of
/// a (in node order) touches no triangle of b. Bit i of `edges_a`: edge i of a (Features::element_edges) touches no
/// edge of b. The other two members are the same for b. Features without a bit are never masked, so that large
/// polytopes are only culled less.
struct FeatureMask {
  std::uint32_t vertices_a = 0, vertices_b = 0;
  std::uint64_t edges_a = 0, edges_b = 0;
};

/// The result of a stage for one pair.
enum class PairVerdict {
  keep,
  disjoint,     ///< the convex hulls of the elements are more than step.separation apart during [0, step.t_max]
  contact_free  ///< no feature of one element touches the other; but one element may contain or intersect the other
};

/// A batch of element pairs in element culling. Reused for all batches: no allocation in steady state.
class PairBatch {
 public:
  /// Replaces the contents by these pairs, without masked features.
  void assign(std::span<const ElementPair> list) {
    pairs.assign(list.begin(), list.end());
    masks.assign(list.size(), FeatureMask{});
    contact_free.clear();
  }

  /// Calls `verdict` for each pair, PairVerdict(ElementPair, FeatureMask&), which may add bits to the mask, and removes
  /// the pairs that are not kept. The others keep their order. Always inline, because a kernel for one instruction set
  /// cannot be inlined into a function for another one.
  template <class Verdict>
  [[gnu::always_inline]] void cull(Verdict&& verdict) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const ElementPair pair = pairs[i];
      const PairVerdict found = verdict(pair, masks[i]);
      if (found == PairVerdict::contact_free) contact_free.push_back(pair);
      if (found != PairVerdict::keep) continue;
      pairs[kept] = pair;
      masks[kept++] = masks[i];
    }
    pairs.resize(kept);
    masks.resize(kept);
  }

  std::size_t size() const { return pairs.size(); }
  std::size_t bytes() const { return heap_bytes(pairs, masks, contact_free); }

  std::vector<ElementPair> pairs;
  std::vector<FeatureMask> masks;  ///< masks.size() == pairs.size()
  /// Removed pairs that may overlap at t = 0 (PairVerdict::contact_free).
  std::vector<ElementPair> contact_free;
};

class ElementCulling : public Stage {
 public:
  static constexpr const char* kRole = "element-culling";

  /// Removes pairs that do not touch during [0, step.t_max] from the batch (PairBatch::cull), and adds bits to masks.
  /// The batch may contain pairs of adjacent elements and self pairs; their shared features must not be masked.
  virtual void run(const Step& step, StageState& state, unsigned worker, PairBatch& batch) const = 0;
};

}  // namespace volccd
