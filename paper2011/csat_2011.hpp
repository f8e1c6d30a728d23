// The CSAT implementation of 2011, for Table I as the paper measured it: scalar code, as printed in Section 4.
#pragma once

#include <volccd/query/roles/element_culling.hpp>
#include <volccd/query/roles/feature_filter.hpp>

namespace volccd {

/// Algorithm 2: each vertex of a against b and each vertex of b against a (Corollary 2), along the normal at t = 0 of a
/// picked face of the other element; each edge of a against b (Corollary 4), along its cross product with a picked edge
/// of b. Face and edge are picked once for each element pair, in the same way as for `csat.axis=face`. Separated
/// features are masked; a pair without remaining tests is dropped as contact_free.
///
/// Guarantee: approximate. Signs are those of rounded dot products, without a rounding bound. A zero is regarded as not
/// separated, but if the exact value is zero or nearly zero, rounding may give all values the same sign, and a contact
/// is lost.
///
/// Nothing is culled for separations, for three control points, and for elements with more than 32 vertices or 64
/// edges. t_max is ignored: features that are separated throughout the step are separated until t_max.
class Csat2011 final : public ElementCulling {
 public:
  void run(const Step& step, StageState& state, unsigned worker, PairBatch& batch) const override;
};

/// Corollaries 1 and 3 for single tests, along the normal of the triangle at t = 0 or the cross product of the edges at
/// t = 0, with 4 and 5 dot products as in the paper. Guarantee and limits are those of Csat2011.
class CsatFilter2011 final : public FeatureFilter {
 public:
  void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block,
           std::span<std::uint8_t> keep) const override;
};

StageDescriptor<ElementCulling> describe_csat_2011();
StageDescriptor<FeatureFilter> describe_csat_filter_2011();

}  // namespace volccd
