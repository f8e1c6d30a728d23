// Tests of thickened shells that are not asked for because both features correspond to the same vertex of the shell
// mesh (Step::leave_out_shell_neighbours).
#pragma once

#include <array>
#include <cstddef>

#include <volccd/mesh/shells.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd {

/// Whether the two features of a test in the solid mesh of a ShellThickener have vertices that correspond to the same
/// vertex of the shell mesh. Such features always remain close to each other, however the shells move: at that vertex,
/// features of a shell's prism and its neighbours are one thickness apart, and those of a shell and a volume that
/// shares the vertex are half a thickness apart. `vertices`: slots in the order of test_vertices().
inline bool share_shell_vertex(FeatureKind kind, const std::array<Index, 4>& vertices) {
  const std::size_t second = kind == FeatureKind::vf ? 1 : 2;
  for (std::size_t i = 0; i < second; ++i)
    for (std::size_t j = second; j < 4; ++j)
      if (shell_vertex(vertices[i]) == shell_vertex(vertices[j])) return true;
  return false;
}

}  // namespace volccd
