// No assignment: every element pair performs all of its tests (NavCCD and HashCCD, Sections 3.4 and 6.1).
#pragma once

#include <volccd/culling/assignment.hpp>

namespace volccd {

/// Tests of an element pair (a,b): each vertex of a against each triangle of b, each vertex of b against each triangle
/// of a, each edge of a against each edge of b; of a pair (o,o): each vertex against each triangle, each pair of edges.
/// Without those that share a vertex, and each distinct feature pair once per element pair: adjacent elements share
/// features, and what both have would otherwise come out twice.
///
/// The same feature pair comes out of many element pairs. Complete without an O-Set; with one, an ablation: what O-Sets
/// do without assignment.
class AllPairs final : public Assignment {
 public:
  struct Config {};
  static const Options<Config>& options();

  explicit AllPairs(const Config&) {}

  void run(const Step& step, StageState& state, unsigned worker, const PairBatch& batch, TestBatch& out) const override;
};

StageDescriptor<Assignment> describe_all_pairs();

}  // namespace volccd
