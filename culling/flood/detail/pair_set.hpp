// A set of element pairs.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd::detail {

/// Hash set with open addressing, at most half full. clear() keeps the memory.
class PairSet {
 public:
  void clear() {
    std::fill(places_.begin(), places_.end(), kEmpty);
    size_ = 0;
  }
  std::size_t size() const { return size_; }
  std::size_t bytes() const { return heap_bytes(places_); }

  bool contains(ElementPair pair) const { return !places_.empty() && places_[place_of(key_of(pair))] != kEmpty; }
  /// Inserts a pair, in any order of its elements. Returns false if it is already in the set.
  bool insert(ElementPair pair) {
    if (2 * (size_ + 1) > places_.size()) grow();
    const std::uint64_t key = key_of(pair);
    std::uint64_t& place = places_[place_of(key)];
    if (place == key) return false;
    place = key;
    ++size_;
    return true;
  }

 private:
  static constexpr std::uint64_t kEmpty = ~std::uint64_t{0};

  static std::uint64_t key_of(ElementPair p) { return std::uint64_t{std::min(p.a, p.b)} << 32 | std::max(p.a, p.b); }
  /// Where the key is, or the empty place where it belongs.
  std::size_t place_of(std::uint64_t key) const {
    std::size_t i = static_cast<std::size_t>(key * 0x9e3779b97f4a7c15u >> shift_);
    while (places_[i] != key && places_[i] != kEmpty) i = (i + 1) & (places_.size() - 1);
    return i;
  }
  void grow() {
    std::vector<std::uint64_t> old(std::max<std::size_t>(1024, 2 * places_.size()), kEmpty);
    old.swap(places_);
    shift_ = 64;
    for (std::size_t n = places_.size(); n > 1; n /= 2) --shift_;
    for (const std::uint64_t key : old)
      if (key != kEmpty) places_[place_of(key)] = key;
  }

  std::vector<std::uint64_t> places_;
  std::size_t size_ = 0;
  int shift_ = 64;
};

}  // namespace volccd::detail
