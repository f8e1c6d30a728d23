// Open-addressing hash table of slots whose keys lie elsewhere (in the mesh, in the features): 4 bytes an entry.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <volccd/mesh/types.hpp>

namespace volccd::detail {

/// Linear probing, at most half full. Deletion shifts later entries back, so that there are no tombstones and the table
/// never degrades. Hashes are 32 bits wide; `hash_of(slot)` gives that of a slot in the table again. The number of
/// places is arbitrary (the hash is scaled, not masked), so that a table of known size wastes nothing.
class SlotTable {
 public:
  std::size_t size() const { return size_; }
  std::size_t bytes() const { return places_.capacity() * sizeof(Index); }

  void clear() { *this = SlotTable(); }

  /// Slot with this hash for which `same(slot)` holds, or kNone.
  template <class Same>
  Index find(std::uint32_t hash, Same&& same) const {
    if (places_.empty()) return kNone;
    for (std::size_t i = home(hash); places_[i] != kNone; i = next(i))
      if (same(places_[i])) return places_[i];
    return kNone;
  }

  /// Slot for which `same` holds; if there is none, `slot` is put in and returned. If there is no memory to grow,
  /// nothing changes. It never grows below the greatest size that it has had.
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

  /// The slot must be in the table.
  template <class HashOf>
  void erase(Index slot, HashOf&& hash_of) {
    std::size_t hole = home(hash_of(slot));
    while (places_[hole] != slot) hole = next(hole);
    for (std::size_t i = next(hole); places_[i] != kNone; i = next(i)) {
      // An entry may move back into the hole unless its home lies (cyclically) after the hole.
      const std::size_t h = home(hash_of(places_[i]));
      const bool home_after_hole = hole <= i ? (hole < h && h <= i) : (hole < h || h <= i);
      if (home_after_hole) continue;
      places_[hole] = places_[i];
      hole = i;
    }
    places_[hole] = kNone;
    --size_;
  }

  /// Room for n slots beyond those that are there; may be called at every change.
  template <class HashOf>
  void reserve_more(std::size_t n, HashOf&& hash_of) {
    if (!fits(size_ + n)) resize(places_for(std::max(size_ + n, size_ + size_ / 2 + 16)), hash_of);
  }

  /// Room for n slots without growing.
  template <class HashOf>
  void reserve(std::size_t n, HashOf&& hash_of) {
    if (!fits(n)) resize(places_for(n), hash_of);
  }

 private:
  bool fits(std::size_t n) const { return n * 2 <= places_.size(); }  // at most half full
  static std::size_t places_for(std::size_t n) { return 2 * n + n / 16 + 8; }

  std::size_t home(std::uint32_t hash) const {
    return static_cast<std::size_t>((std::uint64_t{hash} * places_.size()) >> 32);
  }
  std::size_t next(std::size_t i) const { return i + 1 == places_.size() ? 0 : i + 1; }

  template <class HashOf>
  void resize(std::size_t places, HashOf&& hash_of) {
    std::vector<Index> old(places, kNone);
    old.swap(places_);
    for (Index slot : old) {
      if (slot == kNone) continue;
      std::size_t i = home(hash_of(slot));
      while (places_[i] != kNone) i = next(i);
      places_[i] = slot;
    }
  }

  std::vector<Index> places_;
  std::size_t size_ = 0;
};

}  // namespace volccd::detail
