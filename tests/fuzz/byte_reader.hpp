// Reads numbers from a string of bytes; after its end, the numbers are 0.
#pragma once

#include <bit>

#include "targets.hpp"

namespace volccd::fuzz {

class ByteReader {
 public:
  explicit ByteReader(Bytes bytes) : rest_(bytes) {}

  bool empty() const { return rest_.empty(); }
  Bytes rest() const { return rest_; }

  std::uint8_t byte() {
    if (rest_.empty()) return 0;
    const std::uint8_t value = rest_.front();
    rest_ = rest_.subspan(1);
    return value;
  }
  std::int8_t small() { return static_cast<std::int8_t>(byte()); }
  std::uint64_t bits(int bytes) {
    std::uint64_t value = 0;
    for (int i = 0; i < bytes; ++i) value |= std::uint64_t{byte()} << (8 * i);
    return value;
  }
  double any_double() { return std::bit_cast<double>(bits(8)); }
  /// A number in [0, n), n > 0.
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(bits(n > 256 ? 4 : 1)) % n; }

 private:
  Bytes rest_;
};

}  // namespace volccd::fuzz
