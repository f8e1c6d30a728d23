// Hash table with open addressing. It stores slots only (4 bytes per entry); their keys are stored elsewhere (in the
// mesh or the features).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/mesh/tables/distribution.hpp>
#include <volccd/mesh/tables/raw_vector.hpp>
#include <volccd/numerics/types.hpp>

namespace volccd::detail {

/// Uses linear probing; the table is at most half full. Deletion moves later entries back, so that there are no
/// tombstones and lookups do not become slower. Hashes have 32 bits; `hash_of(slot)` recomputes the hash of a stored
/// slot. The number of places is arbitrary, since the hash is scaled rather than masked; a table of known size wastes
/// no memory.
class SlotTable {
 public:
  std::size_t size() const { return size_; }
  std::size_t bytes() const { return heap_bytes(places_); }

  /// The stored slot with this hash for which `same(slot)` is true, or kNone.
  template <class Same>
  Index find(std::uint32_t hash, Same&& same) const {
    if (places_.empty()) return kNone;
    for (std::size_t i = home(hash); places_[i] != kNone; i = next(i))
      if (same(places_[i])) return places_[i];
    return kNone;
  }

  /// The stored slot for which `same` is true. If there is none, inserts `slot` and returns it. If memory for growth is
  /// not available, nothing changes. The table never shrinks.
  template <class Same, class HashOf>
  Index find_or_insert(std::uint32_t hash, Index slot, Same&& same, HashOf&& hash_of) {
    reserve_more(1, hash_of);
    std::size_t i = home(hash);
    for (; places_[i] != kNone; i = next(i))
      if (same(places_[i])) return places_[i];
    places_[i] = slot;
    ++size_;
    return slot;
  }

  /// Removes a slot, which must be in the table.
  template <class HashOf>
  void erase(Index slot, HashOf&& hash_of) {
    std::size_t hole = home(hash_of(slot));
    while (places_[hole] != slot) hole = next(hole);
    for (std::size_t i = next(hole); places_[i] != kNone; i = next(i)) {
      // The entry can move into the hole unless its home position is (cyclically) after the hole.
      const std::size_t h = home(hash_of(places_[i]));
      const bool home_after_hole = hole <= i ? (hole < h && h <= i) : (hole < h || h <= i);
      if (home_after_hole) continue;
      places_[hole] = places_[i];
      hole = i;
    }
    places_[hole] = kNone;
    --size_;
  }

  /// Reserves places for n more slots. It may be called before every change.
  template <class HashOf>
  void reserve_more(std::size_t n, HashOf&& hash_of) {
    if ((size_ + n) * 2 > places_.size()) resize(places_for(std::max(size_ + n, size_ + size_ / 2 + 16)), hash_of);
  }

  /// Replaces the contents by the slots 0 .. n-1, whose keys are distinct. The table does not depend on the number of
  /// threads. Each thread fills ranges of places, which fit into its cache.
  template <class HashOf>
  void fill(Index n, HashOf&& hash_of, Executor& executor) {
    *this = SlotTable();
    if (n == 0) return;
    places_.resize(places_for(n));
    size_ = n;
    Distribution<Entry> entries(n, std::uint64_t{1} << 32, n, executor,
                                [&](std::size_t, std::size_t begin, std::size_t end, auto&& add) {
                                  for (std::size_t i = begin; i < end; ++i)
                                    add(Entry{hash_of(static_cast<Index>(i)), static_cast<Index>(i)});
                                });
    std::vector<std::vector<Entry>> others(entries.ranges());
    entries.for_each_range(executor, [&](std::size_t r, unsigned) {
      others[r] = fill_places(entries[r], home(entries.first_key(r)), home(entries.first_key(r + 1)));
    });
    for (const std::vector<Entry>& list : others)
      for (const Entry& entry : list) {
        std::size_t i = home(entry.hash);
        while (places_[i] != kNone) i = next(i);
        places_[i] = entry.slot;
      }
  }

 private:
  struct Entry {
    std::uint32_t hash;
    Index slot;
    std::uint32_t key() const { return hash; }
  };

  static std::size_t places_for(std::size_t n) { return 2 * n + n / 16 + 8; }

  std::size_t home(std::uint64_t hash) const { return static_cast<std::size_t>((hash * places_.size()) >> 32); }
  std::size_t next(std::size_t i) const { return i + 1 == places_.size() ? 0 : i + 1; }

  /// Sets the places [begin, end) to the entries whose homes are among them and after which there is a free place.
  /// Returns the other entries.
  std::vector<Entry> fill_places(std::span<const Entry> entries, std::size_t begin, std::size_t end) {
    std::fill(places_.data() + begin, places_.data() + end, kNone);
    std::vector<Entry> others;
    for (const Entry& entry : entries) {
      std::size_t i = home(entry.hash);
      while (i < end && places_[i] != kNone) ++i;
      if (i < end)
        places_[i] = entry.slot;
      else
        others.push_back(entry);
    }
    return others;
  }

  template <class HashOf>
  void resize(std::size_t places, HashOf&& hash_of) {
    RawVector<Index> old(places, kNone);
    old.swap(places_);
    for (Index slot : old) {
      if (slot == kNone) continue;
      std::size_t i = home(hash_of(slot));
      while (places_[i] != kNone) i = next(i);
      places_[i] = slot;
    }
  }

  RawVector<Index> places_;
  std::size_t size_ = 0;
};

}  // namespace volccd::detail
