// Room in vectors, so that what follows cannot fail.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace volccd::detail {

/// Room for n more elements; grows as push_back does, so that it may be called at every change.
template <class T>
void reserve_more(std::vector<T>& vector, std::size_t n) {
  const std::size_t size = vector.size() + n;
  if (size > vector.capacity()) vector.reserve(std::max(size, 2 * vector.capacity()));
}

}  // namespace volccd::detail
