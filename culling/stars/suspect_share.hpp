// Whether few vertices have suspect stars.
#pragma once

#include <algorithm>
#include <span>

#include <volccd/query/step.hpp>

namespace volccd::detail {

/// Whether at most the share `max_fraction` of the complete vertices in use (Piece::complete) are suspect.
inline bool few_suspects(const Step& step, std::span<const Index> suspects, double max_fraction) {
  const auto complete = [&](Index v) { return step.piece.is_complete(v); };
  const auto count = std::count_if(suspects.begin(), suspects.end(), complete);
  std::size_t all = step.features().vertex_count();
  if (!step.piece.complete.empty())
    all = static_cast<std::size_t>(
        std::count_if(step.piece.complete.begin(), step.piece.complete.end(), [](std::uint8_t c) { return c != 0; }));
  return static_cast<double>(count) <= max_fraction * static_cast<double>(all);
}

}  // namespace volccd::detail
