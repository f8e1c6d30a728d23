// Numbers the distinct tuples among many, to build all features of a mesh at once.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include <volccd/mesh/incidence_pool.hpp>

namespace volccd::detail {

/// The boundary edges (N = 2) or triangles (N = 3) of all elements, one element after another. The vertices of each
/// tuple are ascending.
template <std::size_t N>
struct Occurrences {
  std::vector<std::array<Index, N>> tuples;
  std::vector<Index> elements;  ///< element of each tuple

  void reserve(std::size_t n) {
    tuples.reserve(n);
    elements.reserve(n);
  }
  void add(const std::array<Index, N>& tuple, Index element) {
    tuples.push_back(tuple);
    elements.push_back(element);
  }
};

/// Sets `tuples` to the distinct tuples in ascending order, `incidence[i]` to the elements of tuples[i] in the order of
/// their occurrences, and `numbers[k]` to the number of the k-th occurrence. There are at most 2^32 - 2 occurrences,
/// and vertices are less than `vertices`.
///
/// Distributes the tuples to buckets by their smallest vertex and sorts each bucket: O(n log n) in the worst case,
/// linear in practice, with fewer cache misses than hashing.
template <std::size_t N>
void number_tuples(const Occurrences<N>& all, Index vertices, std::vector<std::array<Index, N>>& tuples,
                   IncidencePool& incidence, std::vector<Index>& numbers) {
  struct Record {
    std::array<Index, N - 1> rest;  // the tuple without its first vertex
    Index occurrence;
    bool same_tuple(const Record& other) const { return rest[0] == other.rest[0] && rest[N - 2] == other.rest[N - 2]; }
    bool operator<(const Record& other) const {
      if (rest[0] != other.rest[0]) return rest[0] < other.rest[0];
      if (rest[N - 2] != other.rest[N - 2]) return rest[N - 2] < other.rest[N - 2];
      return occurrence < other.occurrence;
    }
  };
  std::vector<Index> end(std::size_t{vertices} + 1);  // end[v]: end of the bucket of vertex v, after filling
  for (const auto& tuple : all.tuples) ++end[tuple[0] + 1];
  for (std::size_t v = 0; v < vertices; ++v) end[v + 1] += end[v];
  std::vector<Record> records(all.tuples.size());
  for (std::size_t k = 0; k < all.tuples.size(); ++k) {
    Record& record = records[end[all.tuples[k][0]]++];
    std::copy(all.tuples[k].begin() + 1, all.tuples[k].end(), record.rest.begin());
    record.occurrence = static_cast<Index>(k);
  }

  std::size_t distinct = 0;
  for (std::size_t v = 0, begin = 0; v < vertices; begin = end[v++]) {
    std::sort(records.begin() + static_cast<std::ptrdiff_t>(begin),
              records.begin() + static_cast<std::ptrdiff_t>(end[v]));
    for (std::size_t i = begin; i < end[v]; ++i) distinct += i == begin || !records[i].same_tuple(records[i - 1]);
  }
  tuples.clear();
  tuples.reserve(with_spare(distinct));
  numbers.resize(all.tuples.size());
  incidence.clear(distinct, all.tuples.size());
  for (std::size_t v = 0, begin = 0; v < vertices; begin = end[v++])
    for (std::size_t i = begin; i < end[v]; ++i) {
      const Index k = records[i].occurrence;
      if (i == begin || !records[i].same_tuple(records[i - 1])) tuples.push_back(all.tuples[k]);
      numbers[k] = static_cast<Index>(tuples.size() - 1);
      incidence.push_back(tuples.size() - 1, all.elements[k]);
    }
}

}  // namespace volccd::detail
