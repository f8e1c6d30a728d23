// For observers: which pairs a stage kept.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace volccd::detail {

/// Sets keep[i] to 1 if all[i] is in `kept`, else to 0. `kept` is a subsequence of `all`.
template <class Pair>
void mark_kept(std::span<const Pair> all, std::span<const Pair> kept, std::vector<std::uint8_t>& keep) {
  keep.assign(all.size(), 0);
  std::size_t next = 0;
  for (std::size_t i = 0; i < all.size() && next < kept.size(); ++i)
    if (all[i] == kept[next]) {
      keep[i] = 1;
      ++next;
    }
}

}  // namespace volccd::detail
