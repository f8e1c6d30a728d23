// The element-culling strategy: drops element pairs, or masks features of a pair, that cannot touch during the step.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <volccd/query/pairs.hpp>
#include <volccd/query/stage.hpp>

namespace volccd {

/// Features of an element pair (a,b) that were shown not to touch the other element. Bit i of `vertices_a`: vertex i of
/// a (node order) touches no triangle of b; bit i of `edges_a`: edge i of a (Features::element_edges) touches no edge
/// of b; likewise for b. Features beyond the bits are never masked: large polytopes are merely culled less.
struct FeatureMask {
  std::uint32_t vertices_a = 0, vertices_b = 0;
  std::uint64_t edges_a = 0, edges_b = 0;
};

/// What a stage has found out about a pair.
enum class PairVerdict {
  keep,
  disjoint,      ///< the convex hulls of the elements stay further apart than step.separation during [0, step.t_max]
  contact_free   ///< no feature of one touches the other; still, one element may lie inside the other, or pierce it
};

/// Element pairs on their way through element culling. Reused from batch to batch: no allocation in steady state.
class PairBatch {
 public:
  /// These pairs, no feature masked.
  void assign(std::span<const ElementPair> list) {
    pairs.assign(list.begin(), list.end());
    masks.assign(list.size(), FeatureMask{});
    contact_free.clear();
  }

  /// Asks for the verdict on each pair, PairVerdict(ElementPair, FeatureMask&), which may add bits to the mask, and
  /// takes out those that are not kept. The order of the rest stays. Always inline: kernels for one instruction set
  /// could not be inlined into a function for another.
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
  std::size_t bytes() const {
    return (pairs.capacity() + contact_free.capacity()) * sizeof(ElementPair) + masks.capacity() * sizeof(FeatureMask);
  }

  std::vector<ElementPair> pairs;
  std::vector<FeatureMask> masks;  ///< masks.size() == pairs.size()
  /// Pairs that were taken out although they may overlap at t = 0 (PairVerdict::contact_free).
  std::vector<ElementPair> contact_free;
};

class ElementCulling : public Stage {
 public:
  static constexpr const char* kRole = "element-culling";

  /// Takes pairs that do not touch during [0, step.t_max] out of the batch (PairBatch::cull), and adds bits to masks.
  /// Pairs of adjacent elements and of an element with itself may occur; their shared features must stay.
  virtual void run(const Step& step, StageState& state, unsigned worker, PairBatch& batch) const = 0;
};

}  // namespace volccd
