// Decomposition of a double into an odd integer and a power of two.
#pragma once

#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>

namespace volccd::detail {

/// x = mantissa * 2^exponent with an odd mantissa.
struct OddParts {
  std::int64_t mantissa;
  int exponent;
};

/// Pre: x is finite and not zero.
inline OddParts odd_parts(double x) {
  assert(std::isfinite(x) && x != 0);
  int exponent;
  const auto mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(x, &exponent), 53));
  const int zeros = std::countr_zero(static_cast<std::uint64_t>(mantissa));
  return {mantissa / (std::int64_t{1} << zeros), exponent - 53 + zeros};
}

}  // namespace volccd::detail
