// The option `k` of the broad phases with k-DOPs.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <volccd/core/error.hpp>

namespace volccd::detail {

inline std::vector<std::pair<std::string, int>> k_choices() {
  return {{"6", 6}, {"14", 14}, {"16", 16}, {"18", 18}, {"24", 24}, {"26", 26}};
}

inline void check_k(int k) {
  for (const auto& choice : k_choices())
    if (choice.second == k) return;
  throw ConfigError("k must be one of 6, 14, 16, 18, 24, 26, not " + std::to_string(k));
}

}  // namespace volccd::detail
