// Assignment `all-pairs`: every element pair performs all of its tests (NavCCD and HashCCD, Sections 3.4 and 6.1).
#pragma once

#include <volccd/query/roles/assignment.hpp>

namespace volccd {

/// Tests of an element pair (a,b): each vertex of a against each triangle of b, each vertex of b against each triangle
/// of a, and each edge of a against each edge of b. Tests of a self pair (o,o): each vertex against each triangle, and
/// each pair of edges. Tests whose features share a vertex are omitted. Each feature pair is tested once per element
/// pair, although adjacent elements have common features, whose pairs would otherwise be generated twice.
///
/// The same feature pair is tested for many element pairs. Complete without an O-Set. Together with an O-Set it shows
/// the effect of O-Sets without assignment.
class AllPairs final : public Assignment {
 public:
  void run(const Step& step, StageState& state, unsigned worker, const PairBatch& batch, TestBatch& out) const override;
};

StageDescriptor<Assignment> describe_all_pairs();

}  // namespace volccd
