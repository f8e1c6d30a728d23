// Brings the contacts of all workers into canonical order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/query/contact.hpp>

namespace volccd::detail {

/// Sorts small keys in place of contacts, and copies each contact once. Reused from step to step without allocation.
/// Not thread-safe; uses the executor.
class ContactOrder {
 public:
  /// Replaces `out` by the contacts of the lists in canonical order, one for each feature pair. Returns the number of
  /// contacts that are left out. Contacts of the same features are equal, so that the result does not depend on how the
  /// contacts are distributed to lists. O(n log n), less for lists of few sorted runs.
  std::size_t collect(std::span<const std::span<const Contact>> lists, Executor& executor, std::vector<Contact>& out);

  std::size_t bytes() const { return (keys_.capacity() + merged_.capacity()) * sizeof(Key); }

 private:
  struct Key {
    std::uint64_t kind_and_first, second_and_third;
    Index fourth;
    std::uint32_t list;
    std::size_t place;

    Key() = default;
    Key(const Contact& c, std::size_t in_list, std::size_t at)
        : kind_and_first(std::uint64_t{c.kind == FeatureKind::ee} << 32 | c.vertices[0]),
          second_and_third(std::uint64_t{c.vertices[1]} << 32 | c.vertices[2]),
          fourth(c.vertices[3]),
          list(static_cast<std::uint32_t>(in_list)),
          place(at) {}

    // Comparisons of the features.
    auto features() const { return std::tuple(kind_and_first, second_and_third, fourth); }
    bool operator<(const Key& b) const { return features() < b.features(); }
    bool operator==(const Key& b) const { return features() == b.features(); }
  };

  void sort_lists(std::span<const std::span<const Contact>> lists, Executor& executor);
  void merge_lists(Executor& executor);

  std::vector<Key> keys_, merged_;
  std::vector<std::size_t> begins_;  ///< of the sorted ranges in keys_, and the end of the last one
};

}  // namespace volccd::detail
