// The (feature, element) pairs of an edit, grouped by feature.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <volccd/numerics/types.hpp>

namespace volccd::detail {

/// Collects pairs in ascending order of elements; sort() groups them by feature, so that the list of each feature is
/// changed once, and lists are changed in the order of their addresses.
class Incidences {
 public:
  void add(Index feature, Index element) { pairs_.push_back({feature, element}); }

  /// To be called once, after all calls of add(). Linear time for large changes.
  void sort();

  /// After sort(): calls visit(feature, elements) for each feature; features and elements are ascending. Allocates no
  /// memory.
  template <class Visit>
  void group(Visit&& visit) const {
    for (std::size_t i = 0; i < pairs_.size();) {
      const std::size_t begin = i;
      while (i < pairs_.size() && pairs_[i].feature == pairs_[begin].feature) ++i;
      visit(pairs_[begin].feature, std::span(elements_).subspan(begin, i - begin));
    }
  }

 private:
  struct Pair {
    Index feature, element;
  };
  void sort_pairs();

  std::vector<Pair> pairs_;
  std::vector<Index> elements_;  ///< elements of pairs_, after sort()
};

}  // namespace volccd::detail
