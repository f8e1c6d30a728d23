// Counts the allocations of the whole test program with operator new, and makes single allocations fail.
#pragma once

#include <cstddef>
#include <new>

namespace volccd::test {

/// Number of allocations since the start.
std::size_t allocation_count();
/// Number of allocations that have not been freed.
std::size_t live_allocations();

enum class Memory {
  lacks_once,  ///< one allocation fails
  stays_out    ///< it and all later ones fail
};

/// While this object exists, the n-th allocation of this thread, counted from 1, throws std::bad_alloc.
class FailingAllocation {
 public:
  explicit FailingAllocation(std::size_t n, Memory memory = Memory::lacks_once);
  ~FailingAllocation();
  FailingAllocation(const FailingAllocation&) = delete;
  FailingAllocation& operator=(const FailingAllocation&) = delete;
  /// Whether an allocation has failed, even if the exception was caught.
  bool failed() const;
};

/// Calls `call` with its first allocation failing, then with its second, and so on until it succeeds; calls `unchanged`
/// after each failure. Returns the number of failures.
template <class Call, class Unchanged>
std::size_t fail_allocations(Memory memory, Call&& call, Unchanged&& unchanged) {
  for (std::size_t n = 1;; ++n) {
    bool failed = false;
    {
      const FailingAllocation failing(n, memory);
      try {
        call();
      } catch (const std::bad_alloc&) {
        failed = true;
      }
    }
    if (!failed) return n - 1;
    unchanged();
  }
}

}  // namespace volccd::test
