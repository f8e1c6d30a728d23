// How many random trials a test makes, and other numbers that the environment sets.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <string>

namespace volccd::test {

/// The whole number that the variable has, or `otherwise` if it is not set.
inline std::uint64_t from_environment(const char* name, std::uint64_t otherwise) {
  const char* given = std::getenv(name);
  return given ? std::strtoull(given, nullptr, 10) : otherwise;
}

/// VOLCCD_TRIALS times the count, at least 1. scripts/test sets a fraction where code is slow (sanitizers, EMU128), and
/// .ci/nightly a large factor. The first seeds stay the same. Throws std::invalid_argument if the variable is not a
/// number.
inline int trials(int count) {
  const char* given = std::getenv("VOLCCD_TRIALS");
  const double wanted = std::round(count * (given ? std::stod(given) : 1.0));
  if (!(wanted >= 0)) throw std::invalid_argument(std::string("VOLCCD_TRIALS is ") + given);
  return static_cast<int>(std::clamp(wanted, 1.0, 1e9));
}

}  // namespace volccd::test
