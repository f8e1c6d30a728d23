// These operators have a source file of their own, because a compiler that sees them together with their calls warns of
// mismatched allocation functions.
#include <volccd/program/allocation_count.hpp>

#include <atomic>
#include <cstdlib>
#include <new>

namespace {

std::atomic<bool> counting{false};
std::atomic<std::size_t> allocations{0};

void* allocate(std::size_t size, std::size_t alignment = 1) {
  if (counting.load(std::memory_order_relaxed)) allocations.fetch_add(1, std::memory_order_relaxed);
  size = size == 0 ? 1 : size;
  for (;;) {
    void* const p = alignment <= alignof(std::max_align_t)
                        ? std::malloc(size)
                        : std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
    if (p) return p;
    const std::new_handler handler = std::get_new_handler();
    if (!handler) throw std::bad_alloc();
    handler();
  }
}

constexpr std::size_t bytes(std::align_val_t alignment) { return static_cast<std::size_t>(alignment); }

}  // namespace

// The other forms call these. Memory comes from malloc(), as that of the standard library's operators does; both are
// freed here, so that sanitizers see no mismatch.
[[gnu::weak]] void* operator new(std::size_t size) { return allocate(size); }
[[gnu::weak]] void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate(size, bytes(alignment));
}
[[gnu::weak]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::weak]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }
[[gnu::weak]] void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
[[gnu::weak]] void operator delete(void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }

namespace volccd {

std::size_t allocation_count() {
  counting = true;
  return allocations;
}

}  // namespace volccd
