#include <volccd/paper2011/paper2011.hpp>

#include <algorithm>

#include <volccd/paper2011/csat_2011.hpp>
#include <volccd/paper2011/provot.hpp>
#include <volccd/pipelines/registry.hpp>

namespace volccd {

namespace {

/// The pipelines of the paper's Table I as measured in 2011, without later improvements. HashCCD uses boxes, as
/// Teschner et al. 2003 do.
void add_pipelines(Registry& registry) {
  const StageChoice bvh{"kdop-bvh", {{"k", "16"}, {"leaf_size", "1"}, {"adjacent_pairs", "vertices"}}};
  const StageChoice boxes{"spatial-hash", {{"k", "6"}}};
  const StageChoice all_pairs{"all-pairs", {}}, provot{"provot", {}};
  registry.add_pipeline({"NavCCD-2011",
                         "NavCCD as in 2011: elements as leaves, scalar elementary test",
                         bvh,
                         {},
                         all_pairs,
                         {},
                         {},
                         provot});
  registry.add_pipeline(
      {"HashCCD-2011", "HashCCD as in 2011: boxes, scalar elementary test", boxes, {}, all_pairs, {}, {}, provot});
  const StageChoice dynamic{"dynamic-assignment", {}}, o_set{"o-set", {{"kind", "literal"}}};
  registry.add_pipeline({"VolCCD-2011",
                         "VolCCD as in 2011: elements as leaves, scalar CSAT and test, printed O-Set",
                         bvh,
                         {{"csat-2011", {}}},
                         dynamic,
                         o_set,
                         {{"feature-csat-2011", {}}},
                         provot});
}

}  // namespace

void add_paper2011(Registry& registry) {
  const auto& stages = registry.stages<NarrowPhase>();
  if (std::ranges::find(stages, "provot", &StageDescriptor<NarrowPhase>::name) != stages.end()) return;
  registry.add(describe_csat_2011());
  registry.add(describe_csat_filter_2011());
  registry.add(describe_provot());
  add_pipelines(registry);
}

}  // namespace volccd
