// What all assignment strategies keep from step to step.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include <volccd/core/options.hpp>
#include <volccd/core/stage.hpp>
#include <volccd/culling/feature_culling.hpp>
#include <volccd/culling/o_set.hpp>
#include <volccd/mesh/adjacency.hpp>

namespace volccd::detail {

class AssignmentState final : public StageState {
 public:
  explicit AssignmentState(OSetKind kind) {
    if (kind != OSetKind::none) o_set_ = std::make_unique<OSet>(kind);
  }

  /// Brings everything up to the topology.
  void update(const Topology& topology);

  const AdjacencyTest& adjacency() const { return adjacency_; }
  std::size_t orphan_blocks() const { return o_set_ ? o_set_->blocks() : 0; }
  void orphans(std::size_t block, TestBatch& out) const { o_set_->append(block, out); }

  std::size_t bytes() const override { return adjacency_.bytes() + (o_set_ ? o_set_->bytes() : 0); }

 private:
  std::uint64_t version_ = 0;
  AdjacencyTest adjacency_;
  std::unique_ptr<OSet> o_set_;  ///< none: the strategy needs no O-Set
};

inline AssignmentState& assignment_state(StageState& state) { return static_cast<AssignmentState&>(state); }
inline const AssignmentState& assignment_state(const StageState& state) {
  return static_cast<const AssignmentState&>(state);
}

/// The option `oset` of all strategies.
template <class Config>
Options<Config>& add_o_set_option(Options<Config>& options) {
  return options.add("oset", &Config::oset,
                     {{"none", OSetKind::none}, {"minimal", OSetKind::minimal}, {"literal", OSetKind::literal}},
                     "pairs that no non-adjacent elements cover: all of them, or Algorithm 3 taken literally");
}

}  // namespace volccd::detail
