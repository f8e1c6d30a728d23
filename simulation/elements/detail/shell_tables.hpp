// Data of ShellForces: triangles and hinges in blocks of neighbours, each with its own copy of the vertices that it
// uses, so that forces are summed in the same order for any number of threads, and a block fits into the cache.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <volccd/mesh/mesh.hpp>
#include <volccd/simulation/elements/detail/shell_law.hpp>
#include <volccd/simulation/elements/element_forces.hpp>

namespace volccd::simulation::detail {

/// The numbers of triangles and of hinges of a block are padded to a multiple of this with copies of zero weight.
inline constexpr std::size_t kShellPadding = 8;
inline constexpr std::size_t kShellBlock = 256;  ///< triangles
/// Doubles for each vertex in a block's copy (position, velocity, two unused) and in its forces.
inline constexpr std::size_t kCopyStride = 8, kForceStride = 4;

/// One triangle of the mesh, with the corners of its shape at rest.
struct ShellElement {
  Index slot = kNone;
  std::int32_t object = 0;
  std::array<Index, 3> vertices{};
  std::array<Vec3, 3> corners;
};

struct ShellBlock {
  std::size_t triangles_begin, triangles_end, hinges_begin, hinges_end;  ///< padding included
  std::size_t vertices_begin, vertices_end;                              ///< in block_vertices
  std::int32_t object;
};

/// Sums and maxima over one block in one call.
struct ShellSums {
  double elastic = 0, plastic = 0, viscous_power = 0;
  double membrane = 0, hinge = 0;  ///< greatest squared frequency
  double hinge_damping = 0;        ///< the same times the viscosity's time
};

/// Structure of arrays, padded. Vertices are indices into the block's copy, times kCopyStride.
struct ShellTriangles {
  std::vector<std::int32_t> vertices[3];
  std::vector<double> shape[4];  ///< inverse of the edges at rest, plastic flow included (state): F = [a b] shape
  std::vector<double> strain;    ///< equivalent plastic (state)
  std::vector<double> volume;    ///< at rest; 0: padding
  std::vector<std::array<double, 4>> edges;  ///< at rest, the inverse of `shape` before any flow
  std::vector<Index> element;                ///< index into elements, kNone: padding
};

struct ShellHinges {
  std::vector<std::int32_t> vertices[4];       ///< those of the edge, then the opposite ones of both triangles
  std::vector<double> stiffness;               ///< moment over angle
  std::vector<double> rest, last;              ///< angles (state)
  std::vector<double> capacity;                ///< moment at which it flows (state)
  std::vector<double> min[2];                  ///< squares of twice the areas below which the moment is reduced
  std::vector<double> viscosity;               ///< time
  std::vector<double> mobility[3];             ///< stiffness over share of mass: at the edge, at the opposite vertices
  std::vector<double> reference;               ///< angle at rest before any flow
  std::vector<double> virgin, slope, strain;   ///< capacity before any flow; its increase and plastic strain per angle
  std::vector<std::array<Index, 2>> elements;  ///< indices into elements, kNone: padding
  std::vector<std::int32_t> object;            ///< body that yields first
  std::vector<std::uint8_t> opposed;           ///< whether the two triangles run through the edge in opposite senses
};

struct ShellTables {
  std::vector<ShellLaw> laws;          ///< by object
  std::vector<ShellElement> elements;  ///< deformable ones first, in the order of the blocks
  std::size_t deformable = 0;
  Index mesh_vertices = 0;

  std::vector<ShellBlock> blocks;
  ShellTriangles triangles;
  ShellHinges hinges;
  std::size_t hinge_count = 0;
  std::vector<Index> pending;  ///< hinges whose next angle becomes their rest angle

  std::vector<Index> block_vertices;         ///< mesh vertex of each entry of a copy
  std::vector<Index> used, offsets, places;  ///< CSR: entries of each used mesh vertex
  std::vector<Vec3> block_forces;
  std::vector<ShellSums> sums;
  std::size_t greatest_copy = 0;             ///< vertices of a block
  std::vector<std::vector<double>> scratch;  ///< by worker
  std::vector<Vec3> positions;               ///< of the last call

  double elastic = 0, plastic = 0, numerical = 0;
  ShellSums greatest;  ///< frequencies of the last call

  /// Builds all tables for these elements, without plastic flow.
  void build(std::vector<ShellElement> all, Index vertex_count);
  void archive(Archive& archive);
};

/// Edges (column a, then b) of a triangle in its own plane: a lies along the first axis.
struct RestFrame {
  Vec3 axes[2];
  std::array<double, 4> edges;  ///< a.x b.x / a.y b.y by rows
  double area;                  ///< 0: degenerate, the other members are unused
  explicit RestFrame(const std::array<Vec3, 3>& corners);
};
std::array<double, 4> inverse2(const std::array<double, 4>& m);
std::array<double, 4> product2(const std::array<double, 4>& a, const std::array<double, 4>& b);

/// Angle at the edge x0 x1 between triangles x0 x1 x2 and x1 x0 x3; 0 when flat.
double hinge_angle(const Vec3& x0, const Vec3& x1, const Vec3& x2, const Vec3& x3);

}  // namespace volccd::simulation::detail
