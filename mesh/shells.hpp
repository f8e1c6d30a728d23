// Shells as solids: triangles become wedges and quads hexahedra, by their thickness along vertex normals.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/mesh/mesh.hpp>

namespace volccd {

/// Vertices of the solid mesh that vertex v of the shell mesh stands for: v itself, for volumes, and the two that a
/// shell's vertex splits into. All vertices get all three, used or not, so that slots do not depend on which elements
/// there are and edits of the shell mesh carry over. Ids go the same way (solid_vertex_ids).
constexpr Index solid_middle(Index v) { return 3 * v; }
constexpr Index solid_below(Index v) { return 3 * v + 1; }
constexpr Index solid_above(Index v) { return 3 * v + 2; }
/// The vertex of the shell mesh that a vertex of the solid mesh stems from.
constexpr Index shell_vertex(Index solid) { return solid / 3; }

/// 3 id, 3 id + 1, 3 id + 2 for each id. Throws InputError for ids beyond a third of the range of 64 bits.
std::vector<std::int64_t> solid_vertex_ids(std::span<const std::int64_t> ids);

/// Made once for a topology; then maps positions at any time to positions of the solid mesh, for both ends of a motion
/// alike. Immutable: thread-safe.
///
/// Below and above lie h/2 off a vertex along its normal. Normal and h are means over all shells at the vertex,
/// weighted by area, of whatever object: objects joined at a vertex stay joined. Shells that share an edge are brought
/// to one orientation first, in which the shell of smallest id counts as it is, so that normals of a sheet whose
/// elements are numbered in both directions do not cancel and no solid is twisted. That is a matter of topology alone,
/// and the same at both ends. (A Moebius strip, or sheets that meet in a vertex only, may have a twisted solid:
/// degenerate, but legal.) No allowance is made for creases: a solid is thinner there than h.
///
/// A shell and a volume that it is glued to have no vertex in common afterwards: they count as touching from the start.
class ShellThickener {
  struct Sheet {
    Vec3 normal;  ///< times area
    double area;
  };

 public:
  /// Memory that positions() uses again, for any thickener: by one call at a time.
  class Scratch {
    friend class ShellThickener;
    std::vector<Sheet> sheets_;  ///< each shell's, which several vertices ask for
  };

  explicit ShellThickener(const Mesh& mesh);

  /// Solid of live element o of the mesh this was made for; a volume comes back as it is, on the middle vertices.
  /// Object and id are kept. Solids have positive volume in VTK's sense where the sheet is flat.
  ElementSpec solid_element(const Mesh& mesh, Index o) const;
  /// All elements, in the order of their slots, which are the same if the mesh has no empty ones.
  Mesh solid_mesh(const Mesh& mesh) const;

  /// Replaces `out` by the positions of the solid mesh, 3 for each of `x` (one a vertex). `thickness`: one an element
  /// slot; entries of other elements are not read. Returns the number of vertices without a normal, because their
  /// shells have no area or are folded back onto each other: there the first shell with an area, by id, gives it, else
  /// the z axis. Throws InputError (source "shells", dataset "positions" or "thickness", index) for arrays of the wrong
  /// length and for a thickness that is negative or not finite. Allocates only while `out` and the scratch grow. Same
  /// bits for any number of workers; without an executor, on the calling thread, with scratch of its own.
  Index positions(std::span<const Vec3> x, std::span<const double> thickness, std::vector<Vec3>& out, Scratch& scratch,
                  Executor& executor) const;
  Index positions(std::span<const Vec3> x, std::span<const double> thickness, std::vector<Vec3>& out) const;

 private:
  struct Shell {
    Index slot;
    std::array<Index, 4> vertices;  ///< a triangle repeats its last vertex
    bool flipped;                   ///< against the orientation of its sheet
  };
  struct Corner {
    Index vertex, shell;
  };
  void orient();
  void check(std::span<const Vec3> x, std::span<const double> thickness) const;
  Index split_vertices(std::span<const Vec3> x, std::span<const double> thickness, std::span<const Sheet> sheets,
                       std::span<const Index> runs, std::span<Vec3> out) const;

  Index vertices_ = 0, slots_ = 0;
  std::vector<Shell> shells_;    ///< by element id
  std::vector<Corner> corners_;  ///< by vertex, then shell
  std::vector<Index> runs_;      ///< where in corners_ each vertex of a shell begins, and the end
  std::vector<Index> flipped_;   ///< slots, ascending
};

}  // namespace volccd
