// Equal parts of a mesh, one for each rank.
#pragma once

#include <cstdint>

#include <volccd/distributed/elements.hpp>
#include <volccd/query/motion.hpp>

namespace volccd::distributed {

/// Consecutive slots or rows, [begin, end).
struct PartRange {
  Index begin = 0, end = 0;

  Index size() const { return end - begin; }
};

/// The part of `count` slots or rows that a rank gives. Parts differ by one at most.
inline PartRange part_of(Index count, int rank, int ranks) {
  const auto begin = [&](int r) {
    return static_cast<Index>(std::uint64_t{count} * static_cast<std::uint64_t>(r) / static_cast<std::uint64_t>(ranks));
  };
  return {begin(rank), begin(rank + 1)};
}

/// The live elements in a range of slots.
inline Elements elements_in(const Mesh& mesh, PartRange slots) {
  Elements elements;
  for (Index o = slots.begin; o < slots.end; ++o)
    if (mesh.is_live(o)) elements.add(mesh, o);
  return elements;
}

/// Makes `part` the motion of the vertices in a range of slots.
inline void copy_motion(const Motion& whole, PartRange slots, Motion& part) {
  if (part.vertex_count() != slots.size() || part.control_points() != whole.control_points())
    part = Motion(slots.size(), whole.control_points());
  for (Index v = 0; v < slots.size(); ++v)
    for (int c = 0; c < whole.control_points(); ++c) part.set(v, c, whole.point(slots.begin + v, c));
}

}  // namespace volccd::distributed
