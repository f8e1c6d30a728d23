// Many short lists from pairs of key and value, in parallel.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <volccd/mesh/incidence_pool.hpp>
#include <volccd/mesh/tables/distribution.hpp>

namespace volccd::detail {

struct KeyValue {
  Index list, value;
  Index key() const { return list; }
};

/// Fills the lists [first, last), which take the entries of the pool from `begin` on.
inline void group_range(std::span<const KeyValue> pairs, std::size_t first, std::size_t last, std::size_t begin,
                        IncidencePool& pool) {
  std::vector<Index> next(last - first);
  for (const KeyValue& pair : pairs) ++next[pair.list - first];
  for (std::size_t i = first; i < last; ++i) {
    const Index length = next[i - first];
    pool.place(i, begin, length);
    next[i - first] = static_cast<Index>(begin);
    begin += length;
  }
  const std::span<Index> entries = pool.entries();
  for (const KeyValue& pair : pairs) entries[next[pair.list - first]++] = pair.value;
}

/// Replaces the contents of the pool by `lists` lists: list i contains the values of the pairs with key i, in the order
/// of their items. `items`, `expected` and `visit` are those of a Distribution of KeyValue. Linear time.
template <class Visit>
void group_by_key(std::size_t items, std::size_t lists, std::size_t expected, Executor& executor, Visit&& visit,
                  IncidencePool& pool) {
  Distribution<KeyValue> pairs(items, lists, expected, executor, visit);
  pool.allocate(lists, pairs.size());
  pairs.for_each_range(executor, [&](std::size_t r, unsigned) {
    group_range(pairs[r], pairs.first_key(r), pairs.first_key(r + 1), pairs.begin(r), pool);
  });
}

}  // namespace volccd::detail
