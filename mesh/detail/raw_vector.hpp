// A vector for large tables that several threads fill.
#pragma once

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

}  // namespace volccd::detail
