#include <cstdio>
#include <cstdlib>

#include "targets.hpp"

namespace volccd::fuzz {

void promise_broken(const std::string& what) {
  std::fprintf(stderr, "promise broken: %s\n", what.c_str());
  std::abort();
}

}  // namespace volccd::fuzz
