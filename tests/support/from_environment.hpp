// Numbers that an environment variable sets: how much a long test does (.ci/nightly).
#pragma once

#include <cstdint>
#include <cstdlib>

namespace volccd::test {

/// The number that the variable has, or `otherwise` if it is not set.
inline std::uint64_t from_environment(const char* name, std::uint64_t otherwise) {
  const char* given = std::getenv(name);
  return given ? std::strtoull(given, nullptr, 10) : otherwise;
}

}  // namespace volccd::test
