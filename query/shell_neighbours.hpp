// Which tests of thickened shells are none: both features stem from one vertex of the shell mesh.
#pragma once

#include <array>
#include <cstddef>

#include <volccd/mesh/shells.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd {

/// Whether the two features of a test, in the solid mesh of a ShellThickener, have vertices that stem from one vertex
/// of the shell mesh. Such features never come apart, whatever the shells do: those of a prism and of its neighbours
/// are as far apart at that vertex as the shell is thick, those of a shell and a volume that it is glued to by half of
/// that. `vertices`: slots in the order of test_vertices().
inline bool share_shell_vertex(FeatureKind kind, const std::array<Index, 4>& vertices) {
  const std::size_t second = kind == FeatureKind::vf ? 1 : 2;
  for (std::size_t i = 0; i < second; ++i)
    for (std::size_t j = second; j < 4; ++j)
      if (shell_vertex(vertices[i]) == shell_vertex(vertices[j])) return true;
  return false;
}

}  // namespace volccd
