// A vector for large tables that several threads fill, and how vectors grow.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

namespace volccd::detail {

/// std::allocator, except that elements without a given value are left uninitialized.
template <class T>
class RawAllocator : public std::allocator<T> {
 public:
  template <class U>
  struct rebind {
    using other = RawAllocator<U>;
  };

  RawAllocator() = default;
  template <class U>
  RawAllocator(const RawAllocator<U>&) noexcept {}

  template <class U>
  void construct(U* at) noexcept {
    static_assert(std::is_trivially_default_constructible_v<U>);
    ::new (static_cast<void*>(at)) U;
  }
  template <class U, class... Args>
  void construct(U* at, Args&&... args) {
    ::new (static_cast<void*>(at)) U(std::forward<Args>(args)...);
  }
};

/// A vector whose resize(n) leaves the new elements uninitialized; resize(n, value) initializes them. Thus the threads
/// that write the elements are the first to access their memory, and the system provides the pages in parallel.
template <class T>
using RawVector = std::vector<T, RawAllocator<T>>;

/// Resizes to n elements, with a reserve so that the first changes do not reallocate them.
template <class T>
void resize_with_spare(RawVector<T>& vector, std::size_t n) {
  vector.reserve(n + n / 16);
  vector.resize(n);
}

/// Reserves capacity for n more elements, so that adding these cannot fail. The capacity grows geometrically as with
/// push_back, so that the function may be called before every change.
template <class T, class Allocator>
void reserve_more(std::vector<T, Allocator>& vector, std::size_t n) {
  const std::size_t size = vector.size() + n;
  if (size > vector.capacity()) vector.reserve(std::max(size, 2 * vector.capacity()));
}

}  // namespace volccd::detail
