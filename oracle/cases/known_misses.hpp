// Tests for which an earlier version of a narrow phase missed the contact, reported it too early, or reported features
// too far apart.
#pragma once

#include <ostream>
#include <vector>

#include <volccd/oracle/cases/near_degenerate.hpp>

namespace volccd::cases {

struct KnownMiss {
  const char* name;
  Case test;
};

inline void PrintTo(const KnownMiss& miss, std::ostream* out) { *out << miss.name; }

std::vector<KnownMiss> known_misses();

}  // namespace volccd::cases
