// Counts what the whole test program allocates with operator new, and makes single allocations fail.
#pragma once

#include <cstddef>

namespace volccd::test {

/// Since the start.
std::size_t allocation_count();
/// Not freed yet.
std::size_t live_allocations();

enum class Memory {
  lacks_once,   ///< one allocation fails
  stays_out     ///< it and all later ones fail
};

/// While it lives, the n-th allocation of this thread, counted from 1, throws std::bad_alloc.
class FailingAllocation {
 public:
  explicit FailingAllocation(std::size_t n, Memory memory = Memory::lacks_once);
  ~FailingAllocation();
  FailingAllocation(const FailingAllocation&) = delete;
  FailingAllocation& operator=(const FailingAllocation&) = delete;
  /// Whether one has failed, thrown on or not.
  bool failed() const;
};

}  // namespace volccd::test
