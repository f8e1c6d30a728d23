// Which pairs of objects a query looks at.
#pragma once

#include <cstdint>
#include <set>
#include <utility>

#include <volccd/mesh/topology.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd {

enum class PairScope {
  all,
  inter,  ///< between different objects
  intra   ///< within one object
};

/// A rule on pairs of object ids, symmetric. A feature belongs to every object that has an element incident to it. A
/// feature pair {a,b} is asked for when some (oi, oj) in inc(a) x inc(b) has an allowed pair of objects.
///
/// Culling on element pairs is exact only if objects share no vertices: otherwise an element pair may own (assignment)
/// a feature pair that is asked for because of other elements. Therefore element pairs are only dropped when both
/// elements are pure: no vertex of them belongs to an element of another object.
class ObjectFilter {
 public:
  ObjectFilter() = default;
  explicit ObjectFilter(PairScope scope) : scope_(scope) {}

  /// Never look at contacts between objects a and b (a == b: within it).
  void exclude(std::int32_t a, std::int32_t b) { excluded_.insert(std::minmax(a, b)); }

  bool allows(std::int32_t a, std::int32_t b) const {
    if (scope_ == PairScope::inter && a == b) return false;
    if (scope_ == PairScope::intra && a != b) return false;
    return excluded_.empty() || !excluded_.contains(std::minmax(a, b));
  }
  /// True if everything is allowed: nothing to ask.
  bool trivial() const { return scope_ == PairScope::all && excluded_.empty(); }

  PairScope scope() const { return scope_; }

  /// Whether the element pair may be dropped by a broad phase, under the rule above.
  bool drops(const Topology& topology, ElementPair pair) const;
  /// Whether the feature pair is asked for.
  bool asks_for(const Topology& topology, FeatureKind kind, FeaturePair pair) const;

  friend bool operator==(const ObjectFilter&, const ObjectFilter&) = default;

 private:
  PairScope scope_ = PairScope::all;
  std::set<std::pair<std::int32_t, std::int32_t>> excluded_;
};

}  // namespace volccd
