// Which pairs of objects a query includes.
#pragma once

#include <array>
#include <cstdint>
#include <set>
#include <utility>

#include <volccd/core/named_values.hpp>
#include <volccd/mesh/topology.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd {

enum class PairScope {
  all,
  inter,  ///< between different objects
  intra   ///< within one object
};
constexpr std::array<NamedValue<PairScope>, 3> names_of(PairScope) {
  return {{{"all", PairScope::all}, {"inter", PairScope::inter}, {"intra", PairScope::intra}}};
}

/// A symmetric rule on pairs of object ids. A feature belongs to every object that has an element incident to it. A
/// feature pair {a,b} is included if some (oi, oj) in inc(a) x inc(b) has an allowed pair of objects.
///
/// Element pairs may be dropped by their objects only if objects share no vertices; otherwise an element pair may own
/// (by assignment) a feature pair that is included because of other elements. Therefore an element pair is dropped only
/// if neither element has a vertex that belongs to an element of another object.
class ObjectFilter {
 public:
  ObjectFilter() = default;
  explicit ObjectFilter(PairScope scope) : scope_(scope) {}

  /// Excludes contacts between the objects a and b (if a == b: within the object).
  void exclude(std::int32_t a, std::int32_t b) { excluded_.insert(std::minmax(a, b)); }

  bool allows(std::int32_t a, std::int32_t b) const {
    if (scope_ == PairScope::inter && a == b) return false;
    if (scope_ == PairScope::intra && a != b) return false;
    return excluded_.empty() || !excluded_.contains(std::minmax(a, b));
  }
  /// True if every pair is allowed.
  bool trivial() const { return scope_ == PairScope::all && excluded_.empty(); }

  PairScope scope() const { return scope_; }
  /// The excluded pairs, the smaller object first, ascending.
  const std::set<std::pair<std::int32_t, std::int32_t>>& excluded() const { return excluded_; }

  /// Whether a broad phase may drop the element pair, by the rule above.
  bool drops(const Topology& topology, ElementPair pair) const;
  /// Whether the feature pair is included.
  bool asks_for(const Topology& topology, FeatureKind kind, FeaturePair pair) const;

  friend bool operator==(const ObjectFilter&, const ObjectFilter&) = default;

 private:
  PairScope scope_ = PairScope::all;
  std::set<std::pair<std::int32_t, std::int32_t>> excluded_;
};

}  // namespace volccd
