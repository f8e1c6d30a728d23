// (feature, element) pairs of a change, grouped by feature.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <volccd/mesh/types.hpp>

namespace volccd::detail {

/// Collects pairs element by element, elements ascending; group() then puts all elements of a feature together, so that
/// each feature's list is changed once and in the order of memory.
class Incidences {
 public:
  void clear() { pairs_.clear(); }
  void add(Index feature, Index element) { pairs_.push_back({feature, element}); }

  /// Calls visit(feature, elements) for each feature, features and elements ascending. Linear time for large changes.
  template <class Visit>
  void group(Visit&& visit) {
    sort();
    for (std::size_t i = 0; i < pairs_.size();) {
      const Index feature = pairs_[i].feature;
      elements_.clear();
      for (; i < pairs_.size() && pairs_[i].feature == feature; ++i) elements_.push_back(pairs_[i].element);
      visit(feature, std::span<const Index>(elements_));
    }
  }

 private:
  struct Pair {
    Index feature, element;
  };
  void sort();

  std::vector<Pair> pairs_, scratch_;
  std::vector<Index> elements_;
};

}  // namespace volccd::detail
