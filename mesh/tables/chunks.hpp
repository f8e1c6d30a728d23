// Division of an index range into numbered chunks.
#pragma once

#include <algorithm>
#include <cstddef>

#include <volccd/core/executor.hpp>

namespace volccd::detail {

/// Chunks of equal length, except for the last; their number depends on the length of the range only. In contrast to
/// the chunks of an Executor, they are the same in every loop, so that one loop can count what the next one stores.
class Chunks {
 public:
  explicit Chunks(std::size_t n) : n_(n), length_(std::max(kMinLength, (n + kMaxCount - 1) / kMaxCount)) {}

  std::size_t count() const { return (n_ + length_ - 1) / length_; }

  /// Calls body(chunk, begin, end) for each chunk, in parallel.
  template <class Body>
  void for_each(Executor& executor, Body&& body) const {
    executor.parallel_for(count(), 1, [&](std::size_t first, std::size_t last, unsigned) {
      for (std::size_t c = first; c < last; ++c) body(c, c * length_, std::min(n_, (c + 1) * length_));
    });
  }

 private:
  static constexpr std::size_t kMinLength = 1024, kMaxCount = 256;

  std::size_t n_, length_;
};

}  // namespace volccd::detail
