// Conversion of shells to solids: triangles become wedges and quads become hexahedra, thickened along vertex normals.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/mesh/mesh.hpp>

namespace volccd {

/// Vertices of the solid mesh that correspond to vertex v of the shell mesh: v itself, which volumes use, and the two
/// vertices into which a vertex of a shell is split. Every vertex gets all three, used or not, so that slots do not
/// depend on the elements, and an edit of the shell mesh applies to the solid mesh. Ids are mapped in the same way
/// (solid_vertex_ids).
constexpr Index solid_middle(Index v) { return 3 * v; }
constexpr Index solid_below(Index v) { return 3 * v + 1; }
constexpr Index solid_above(Index v) { return 3 * v + 2; }
/// The vertex of the shell mesh to which a vertex of the solid mesh corresponds.
constexpr Index shell_vertex(Index solid) { return solid / 3; }

/// The ids 3 id, 3 id + 1, 3 id + 2 for each id. Throws InputError for ids beyond a third of the 64-bit range.
std::vector<std::int64_t> solid_vertex_ids(std::span<const std::int64_t> ids);

/// Replaces `out` by the middle control points of the quadratic motion of a solid mesh whose shell mesh has the control
/// points x0, xm, x1; `solid0` and `solid1` are the positions of the solid mesh at both ends (ShellThickener). A vertex
/// that stems from a shell vertex keeps the curvature of the motion of that vertex; its offset from it is linear in
/// time.
void solid_middle_points(std::span<const Vec3> x0, std::span<const Vec3> xm, std::span<const Vec3> x1,
                         std::span<const Vec3> solid0, std::span<const Vec3> solid1, std::vector<Vec3>& out);

/// Constructed once for a topology; then maps positions at any time to positions of the solid mesh, in the same way at
/// both ends of a motion. Immutable, hence thread-safe.
///
/// The two vertices `below` and `above` are at distance h/2 from a vertex along its normal. The normal and h are means
/// over all shells at the vertex, weighted by area, regardless of objects: objects that share a vertex stay connected.
/// First, shells that share an edge are given a consistent orientation, that of the shell of smallest id, so that the
/// normals of a sheet with inconsistent node orders do not cancel and no solid is twisted. This orientation depends on
/// the topology alone and is the same at both ends. (A Moebius strip, or sheets that share only a vertex, may have a
/// twisted solid, which is degenerate but valid.) There is no correction at creases: a solid is thinner than h there.
///
/// A shell and a volume that share vertices have no vertex in common in the solid mesh: they touch at t = 0.
class ShellThickener {
  struct Sheet {
    Vec3 normal;  ///< unit normal times area
    double area;
  };

 public:
  /// Memory for positions() that can be reused, with any thickener, by one call at a time.
  class Scratch {
    friend class ShellThickener;
    std::vector<Sheet> sheets_;  ///< normal and area of each shell, which several vertices use
  };

  explicit ShellThickener(const Mesh& mesh);

  /// The solid of live element o of the mesh that was passed to the constructor. A volume is returned unchanged, on the
  /// middle vertices. Object and id are kept. Where the sheet is flat, the solid has positive volume in VTK's node
  /// order.
  ElementSpec solid_element(const Mesh& mesh, Index o) const;
  /// All elements in ascending order of slots; they have the same slots as in `mesh` if that has no empty slot.
  Mesh solid_mesh(const Mesh& mesh) const;

  /// Throws the InputErrors of positions() for this thickness.
  void check_thickness(std::span<const double> thickness) const;

  /// Replaces `out` by the positions of the solid mesh, three for each vertex in `x`. `thickness` has one entry for
  /// each element slot; the entries of volumes and empty slots are not read. Returns the number of vertices without a
  /// mean normal, because their shells have no area or are folded onto each other: such a vertex takes the normal of
  /// its first shell with an area, by id, otherwise the z axis. Throws InputError (source "shells", dataset "positions"
  /// or "thickness", index) for arrays of wrong length and for a thickness that is negative or not finite. Allocates
  /// only while `out` and the scratch memory grow. The result has the same bits for any number of workers. The overload
  /// without an executor runs on the calling thread with its own scratch memory.
  Index positions(std::span<const Vec3> x, std::span<const double> thickness, std::vector<Vec3>& out, Scratch& scratch,
                  Executor& executor) const;
  Index positions(std::span<const Vec3> x, std::span<const double> thickness, std::vector<Vec3>& out) const;

 private:
  struct Shell {
    Index slot;
    std::array<Index, 4> vertices;  ///< a triangle repeats its last vertex
    bool flipped;                   ///< whether its node order is opposite to the orientation of its sheet
  };
  struct Corner {
    Index vertex, shell;
  };
  void orient();
  Index split_vertices(std::span<const Vec3> x, std::span<const double> thickness, std::span<const Sheet> sheets,
                       std::span<const Index> runs, std::span<Vec3> out) const;

  Index vertices_ = 0, slots_ = 0;
  std::vector<Shell> shells_;    ///< in the order of element ids
  std::vector<Corner> corners_;  ///< in the order of vertices, then shells
  std::vector<Index> runs_;      ///< start in corners_ of each vertex of a shell, and the end
  std::vector<Index> flipped_;   ///< slots of flipped shells, ascending
};

}  // namespace volccd
