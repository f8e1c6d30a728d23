// Projections of all vertices on the eight axes of the 16-DOP (numerics/kdop.hpp) at each control point.
#pragma once

#include <cstddef>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/numerics/kdop.hpp>
#include <volccd/query/motion.hpp>

namespace volccd::detail {

inline constexpr std::size_t kRowAxisCount = kdop_axes<16>().size();

/// The projections of a vertex at one control point, each rounded to double precision and then to the nearest float.
/// All axes have one or two terms. Both roundings are monotone: projections are in the order of their rounded values.
/// Apart from underflow, they are within 2^-23 |f| of these values f; an overflow gives an infinite value or the
/// greatest float.
struct alignas(32) VertexRow {
  float at[kRowAxisCount];
};

/// A distance times the lengths of the axes, rounded upward.
inline VertexRow row_of_distance(double distance) {
  constexpr auto axes = kdop_axes<16>();
  VertexRow row;
  for (std::size_t i = 0; i < kRowAxisCount; ++i)
    row.at[i] = float_above(distance * (axis_terms(axes[i]) == 1 ? 1 : 0x1.6a09e667f3bcdp+0));
  return row;
}

/// Row c of vertex v is rows[v * control_points + c]. Compiled for each instruction set.
void project_vertices(const Motion& motion, Executor& executor, std::vector<VertexRow>& rows);

}  // namespace volccd::detail
