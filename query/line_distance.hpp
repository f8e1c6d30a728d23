// Distances of a motion from straight lines, many vertices at a time.
#pragma once

#include <array>
#include <cstddef>

#include <volccd/query/motion.hpp>

namespace volccd::detail {

/// Vertices are compared in groups of up to this many.
constexpr Index kDistanceGroup = 4;

/// Passes over vertices from `begin` on whose control points are near those points of lines that belong to them: by a
/// squared distance of at most `square`, up to rounding in the last bits. `times`: of the control points on the lines.
/// Returns where it stopped: a vertex among the next kDistanceGroup may be further away (or its distance no number), or
/// these reach beyond `end`. Pre: both have two control points and all these vertices. O(end - begin).
Index pass_near_vertices(const Motion& motion, const Motion& lines, const std::array<double, 2>& times, double square,
                         Index begin, Index end);

}  // namespace volccd::detail
