// The heap memory of the members of an object, for its bytes().
#pragma once

#include <cstddef>
#include <vector>

namespace volccd {

template <class... T>
std::size_t heap_bytes(const T&... members);

namespace detail {

template <class T>
std::size_t heap_bytes_of(const T& object) {
  return object.bytes();
}

template <class T, class Allocator>
std::size_t heap_bytes_of(const std::vector<T, Allocator>& list) {
  std::size_t sum = list.capacity() * sizeof(T);
  if constexpr (
      requires(const T& x) { x.bytes(); } || requires(const T& x) { x.capacity(); })
    for (const T& element : list) sum += heap_bytes(element);
  return sum;
}

}  // namespace detail

/// The sum for vectors and for objects with bytes(). The elements of a vector may be such objects, or vectors.
template <class... T>
std::size_t heap_bytes(const T&... members) {
  return (std::size_t{0} + ... + detail::heap_bytes_of(members));
}

}  // namespace volccd
