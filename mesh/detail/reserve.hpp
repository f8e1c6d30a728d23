// Reserves capacity of vectors, so that later insertions cannot fail.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace volccd::detail {

/// Reserves capacity for n more elements. The capacity grows geometrically as with push_back, so that the function may
/// be called before every change.
template <class T, class Allocator>
void reserve_more(std::vector<T, Allocator>& vector, std::size_t n) {
  const std::size_t size = vector.size() + n;
  if (size > vector.capacity()) vector.reserve(std::max(size, 2 * vector.capacity()));
}

}  // namespace volccd::detail
