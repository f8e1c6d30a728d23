// The assignment strategy: determines which VF and EE tests an element pair performs (Section 5.2).
#pragma once

#include <string>

#include <volccd/query/roles/element_culling.hpp>
#include <volccd/query/work_source.hpp>

namespace volccd {

/// The completeness of a pipeline (docs/pipelines.md) relies on the following. The tests of all element pairs of a
/// range must contain:
///  - for all pairs of non-adjacent elements: every feature pair that some pair of non-adjacent elements covers. An
///    OrphanSource adds the others.
///  - for all pairs, including adjacent ones and self pairs (o, o): every feature pair.
/// An element pair covers a feature pair {a,b} if a is a feature of one element and b of the other.
class Assignment : public Stage {
 public:
  static constexpr const char* kRole = "assignment";

  /// Whether this holds for the non-adjacent pairs, and for all pairs: an empty string, or the reason why it does not
  /// hold. A pipeline that requires the property is then refused with this reason.
  virtual std::string incomplete_on_nonadjacent() const { return {}; }
  virtual std::string incomplete_on_every() const { return {}; }

  /// Appends the tests of these element pairs, except tests with a masked feature.
  virtual void run(const Step& step, StageState& state, unsigned worker, const PairBatch& batch,
                   TestBatch& out) const = 0;
};

}  // namespace volccd
