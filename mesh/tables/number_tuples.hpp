// Numbers the distinct tuples among many, to build all features of a mesh at once.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/mesh/features.hpp>
#include <volccd/mesh/tables/distribution.hpp>

namespace volccd::detail {

/// The boundary edges (N = 2) or triangles (N = 3) of all elements. The vertices of each tuple are ascending.
template <std::size_t N>
struct Occurrences {
  /// One element after another within each chunk of Chunks(elements). There may be unused entries between the chunks.
  RawVector<std::array<Index, N>> tuples;
  std::vector<std::size_t> begin;  ///< of each chunk in `tuples`
  RawVector<Index> lengths;        ///< number of tuples of each element

  /// Allocates memory for the tuples; capacities[c] are the most that chunk c has.
  void allocate(std::size_t elements, std::span<const std::size_t> capacities) {
    std::size_t total = 0;
    for (const std::size_t capacity : capacities) {
      begin.push_back(total);
      total += capacity;
    }
    tuples.resize(total);
    lengths.resize(elements);
  }
};

/// A tuple of an element. `occurrence` is the position of the tuple in the list of the features of all elements.
template <std::size_t N>
struct TupleRecord {
  std::array<Index, N> tuple;
  Index element, occurrence;

  Index key() const { return tuple[0]; }
  /// Whether this record precedes another one with the same first vertex. An element has each tuple at most once.
  bool precedes(const TupleRecord& other) const {
    if constexpr (N == 2) {
      return joined(tuple[1], element) < joined(other.tuple[1], other.element);
    } else {
      const std::uint64_t x = joined(tuple[1], tuple[2]), y = joined(other.tuple[1], other.tuple[2]);
      return x != y ? x < y : element < other.element;
    }
  }
  static std::uint64_t joined(Index high, Index low) { return std::uint64_t{high} << 32 | low; }
};

inline constexpr std::size_t kMaxBucketed = std::size_t{1} << 20;

/// Sorts by tuple and element; first vertices are in [first, last). Distributes the records to buckets by their first
/// vertices and sorts each bucket: O(n log n) in the worst case, linear in practice. `scratch` is overwritten.
template <std::size_t N>
void sort_records(std::span<TupleRecord<N>> records, std::size_t first, std::size_t last,
                  RawVector<TupleRecord<N>>& scratch) {
  const auto precedes = [](const TupleRecord<N>& x, const TupleRecord<N>& y) { return x.precedes(y); };
  // Memory for buckets is limited if there are many unused vertices, or if almost all records have few first vertices.
  if (records.size() < last - first || records.size() > kMaxBucketed) {
    std::sort(records.begin(), records.end(), [](const TupleRecord<N>& x, const TupleRecord<N>& y) {
      return x.key() != y.key() ? x.key() < y.key() : x.precedes(y);
    });
    return;
  }
  std::vector<Index> end(last - first + 1);  // end[b]: end of bucket b, after filling
  for (const TupleRecord<N>& record : records) ++end[record.key() - first + 1];
  for (std::size_t b = 1; b < end.size(); ++b) end[b] += end[b - 1];
  scratch.assign(records.begin(), records.end());
  for (const TupleRecord<N>& record : scratch) records[end[record.key() - first]++] = record;
  for (std::size_t b = 0, begin = 0; b + 1 < end.size(); begin = end[b++])
    std::sort(records.begin() + static_cast<std::ptrdiff_t>(begin),
              records.begin() + static_cast<std::ptrdiff_t>(end[b]), precedes);
}

/// The records of all tuples. `of_element` has the lengths of the lists of all elements. Releases the memory of `all`.
template <std::size_t N>
Distribution<TupleRecord<N>> distribute(Occurrences<N>& all, std::size_t vertices, const IncidencePool& of_element,
                                        Executor& executor) {
  const auto add_records = [&](std::size_t chunk, std::size_t begin, std::size_t end, auto&& add) {
    const std::array<Index, N>* tuple = all.tuples.data() + all.begin[chunk];
    Index occurrence = static_cast<Index>(of_element[begin].data() - of_element.entries().data());
    for (std::size_t o = begin; o < end; ++o)
      for (std::size_t n = of_element[o].size(); n != 0; --n)
        add(TupleRecord<N>{*tuple++, static_cast<Index>(o), occurrence++});
  };
  Distribution<TupleRecord<N>> records(of_element.size(), vertices, of_element.entries().size(), executor, add_records);
  all = {};
  return records;
}

/// Number of distinct tuples among sorted records.
template <std::size_t N>
std::size_t count_tuples(std::span<const TupleRecord<N>> records) {
  std::size_t count = !records.empty();
  for (std::size_t i = 1; i < records.size(); ++i) count += !same_tuple(records[i].tuple, records[i - 1].tuple);
  return count;
}

/// Stores sorted records, which are those from position `begin` on; their first tuple has the number `number`.
template <std::size_t N>
void store_tuples(std::span<const TupleRecord<N>> records, std::size_t begin, std::size_t number,
                  TupleFeatures<N>& features) {
  Incidence& incidence = features.incidence;
  const std::span<Index> elements = incidence.elements.entries(), numbers = features.of_element.entries();
  for (std::size_t i = 0, end = 0; i < records.size(); i = end, ++number) {
    features.tuples[number] = records[i].tuple;
    incidence.first[number] = records[i].element;
    for (end = i; end < records.size() && same_tuple(records[end].tuple, records[i].tuple); ++end) {
      elements[begin + end] = records[end].element;
      numbers[records[end].occurrence] = static_cast<Index>(number);
    }
    incidence.elements.place(number, begin + i, end - i);
  }
}

/// Sets the members of `features`, except for the table and incidence.own: `tuples` to the distinct tuples in ascending
/// order, and of_element[o] to the numbers of the tuples of element o in the order of their occurrences. Vertices are
/// less than `vertices`. Releases the memory of `all`. Throws Error if there are more than 2^32 - 2 occurrences.
///
/// Distributes the tuples to ranges of their smallest vertices, and sorts and numbers each range in the cache of a
/// thread; this has fewer cache misses than hashing.
template <std::size_t N>
void number_tuples(Occurrences<N>& all, std::size_t vertices, Executor& executor, TupleFeatures<N>& features) {
  using Records = std::span<const TupleRecord<N>>;
  features.of_element.set_lengths(all.lengths, executor);
  Distribution<TupleRecord<N>> records = distribute(all, vertices, features.of_element, executor);
  std::vector<std::size_t> numbers(records.ranges() + 1);  // of the first tuple of each range
  std::vector<RawVector<TupleRecord<N>>> scratch(executor.workers());
  records.for_each_range(executor, [&](std::size_t r, unsigned worker) {
    sort_records(records[r], records.first_key(r), records.first_key(r + 1), scratch[worker]);
    numbers[r + 1] = count_tuples(Records(records[r]));
  });
  for (std::size_t r = 0; r < records.ranges(); ++r) numbers[r + 1] += numbers[r];
  const std::size_t distinct = numbers.back();
  resize_with_spare(features.tuples, distinct);
  resize_with_spare(features.incidence.first, distinct);
  features.incidence.elements.allocate(distinct, records.size());
  records.for_each_range(executor, [&](std::size_t r, unsigned) {
    store_tuples(Records(records[r]), records.begin(r), numbers[r], features);
  });
}

}  // namespace volccd::detail
