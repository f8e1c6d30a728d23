// In a file of its own, because the compiler warns of a mismatch if it sees these operators together with their calls.
#include "support/allocations.hpp"

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

namespace {

std::atomic<std::size_t> allocations{0}, frees{0};

/// Allocations of this thread.
struct Failure {
  std::size_t countdown = 0;  ///< allocations until one fails; 0: none will
  bool all_after = false, failed = false;
};
thread_local Failure failure;

bool fails() {
  if (failure.countdown == 0) return failure.failed && failure.all_after;
  if (--failure.countdown != 0) return false;
  return failure.failed = true;
}

void* allocate(std::size_t size, std::size_t alignment) noexcept {
  if (fails()) return nullptr;
  void* const p = alignment <= alignof(std::max_align_t)
                      ? std::malloc(size)
                      : std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (p) ++allocations;
  return p;
}

void* allocate_or_throw(std::size_t size, std::size_t alignment) {
  void* const p = allocate(size, alignment);
  if (!p) throw std::bad_alloc();
  return p;
}

void release(void* p) noexcept {
  if (p) ++frees;
  std::free(p);
}

constexpr std::size_t bytes(std::align_val_t alignment) { return static_cast<std::size_t>(alignment); }

}  // namespace

// All allocations of the test program use these operators.
void* operator new(std::size_t size) { return allocate_or_throw(size, 1); }
void* operator new[](std::size_t size) { return allocate_or_throw(size, 1); }
void* operator new(std::size_t size, std::align_val_t a) { return allocate_or_throw(size, bytes(a)); }
void* operator new[](std::size_t size, std::align_val_t a) { return allocate_or_throw(size, bytes(a)); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return allocate(size, 1); }
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept { return allocate(size, 1); }
void operator delete(void* p) noexcept { release(p); }
void operator delete[](void* p) noexcept { release(p); }
void operator delete(void* p, std::size_t) noexcept { release(p); }
void operator delete[](void* p, std::size_t) noexcept { release(p); }
void operator delete(void* p, std::align_val_t) noexcept { release(p); }
void operator delete[](void* p, std::align_val_t) noexcept { release(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { release(p); }
void operator delete[](void* p, std::size_t, std::align_val_t) noexcept { release(p); }

namespace volccd::test {

std::size_t allocation_count() { return allocations; }
std::size_t live_allocations() { return allocations - frees; }

FailingAllocation::FailingAllocation(std::size_t n, Memory memory) {
  failure = {n, memory == Memory::stays_out, false};
}
FailingAllocation::~FailingAllocation() { failure = {}; }
bool FailingAllocation::failed() const { return failure.failed; }

}  // namespace volccd::test
