// The assignment strategy: which VF and EE tests an element pair performs (Section 5.2).
#pragma once

#include <string>
#include <vector>

#include <volccd/culling/element_culling.hpp>

namespace volccd {

/// Tests to run. No pair with a common vertex is ever in it.
struct TestBatch {
  std::vector<FeaturePair> vf, ee;

  std::size_t size() const { return vf.size() + ee.size(); }
  void clear() {
    vf.clear();
    ee.clear();
  }
};

/// Completeness of a pipeline (docs/pipelines.md) rests on what the tests of all pairs of a range contain:
///  - of all pairs of non-adjacent elements: every feature pair that some pair of non-adjacent elements covers.
///    The rest comes from an OrphanSource.
///  - of all pairs, adjacent ones and (o, o) included: every feature pair.
/// An element pair covers a feature pair {a,b} when a is a feature of one element and b of the other.
class Assignment : public Stage {
 public:
  static constexpr const char* kRole = "assignment";

  /// Whether that holds for the non-adjacent pairs, or for all pairs: empty, or the reason why it does not. A pipeline
  /// that would need it is refused with this text.
  virtual std::string incomplete_on_nonadjacent() const { return {}; }
  virtual std::string incomplete_on_every() const { return {}; }

  /// Appends the tests of these element pairs that no mask excludes.
  virtual void run(const Step& step, StageState& state, unsigned worker, const PairBatch& batch,
                   TestBatch& out) const = 0;
};

}  // namespace volccd
