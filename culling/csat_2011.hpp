// CSAT of 2011, for the paper's Table I as it was measured then: scalar, plainly written, as printed (Section 4).
#pragma once

#include <volccd/culling/element_culling.hpp>
#include <volccd/culling/feature_filter.hpp>

namespace volccd {

/// Algorithm 2: each vertex of a against b and each vertex of b against a (Corollary 2) along the normal at t = 0 of a
/// picked face of the other element; each edge of a against b (Corollary 4) along its cross product with a picked edge
/// of b. Face and edge are picked once for each pair of elements, as `csat.axis=face` picks them. What is apart is
/// masked; a pair of which no test is left is dropped as contact_free.
///
/// Guarantee: approximate. Signs are those of rounded dot products, without a bound: a zero counts as not separated,
/// but where the exact value is zero or nearly so, rounding may give all values one sign, and a contact is lost.
///
/// Separations, three control points, and elements of more than 32 vertices or 64 edges: nothing is culled. t_max is
/// ignored: what is apart all along is apart until then.
class Csat2011 final : public ElementCulling {
 public:
  struct Config {};
  static const Options<Config>& options();

  explicit Csat2011(const Config&) {}

  void run(const Step& step, StageState& state, unsigned worker, PairBatch& batch) const override;
};

/// Corollaries 1 and 3 on single tests: the triangle's normal at t = 0, and the cross product of the edges at t = 0,
/// with the paper's 4 and 5 dot products. Guarantee and limits as above.
class CsatFilter2011 final : public FeatureFilter {
 public:
  struct Config {};
  static const Options<Config>& options();

  explicit CsatFilter2011(const Config&) {}

  void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block,
           std::span<std::uint8_t> keep) const override;
};

StageDescriptor<ElementCulling> describe_csat_2011();
StageDescriptor<FeatureFilter> describe_csat_filter_2011();

}  // namespace volccd
