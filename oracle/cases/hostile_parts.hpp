// Parts from which the families of hostile meshes are made.
#pragma once

#include <volccd/oracle/cases/hostile_meshes.hpp>

namespace volccd::cases {

/// Width of a cell, in the unit of the coordinates.
inline constexpr int kCellWidth = 16;

Vec3 lattice_point(Choices& choices, int range);
/// An integer in [low, high].
inline int between(Choices& choices, int low, int high) { return low + choices.below(high - low + 1); }
template <class T>
const T& one_of(Choices& choices, const std::vector<T>& values) {
  return values[static_cast<std::size_t>(choices.below(static_cast<int>(values.size())))];
}

Index add_vertex(Shape& shape, const Vec3& position);
/// Adds an element whose id follows the greatest present id.
void add_element(std::vector<ElementSpec>& elements, ElementType type, std::vector<Index> vertices,
                 std::int32_t object = 0);

/// The elements that fill a cell of eight corners in the order of a hexahedron: one hexahedron or polytope, two wedges,
/// five or six tetrahedra, or six pyramids. `rotation` in [0, 48) maps the cube onto itself and determines the
/// diagonals; from 24 on, elements are inverted. `centre`: a vertex for the pyramids.
enum class CellFilling { hexahedron, polytope, wedges, five_tetrahedra, six_tetrahedra, pyramids };
std::vector<ElementSpec> fill_cell(const std::array<Index, 8>& corners, CellFilling filling, int rotation,
                                   Index centre);

/// A block of cells, filled in one way, or each cell in a way and with diagonals of its own. Sizes are 1 to `size`.
HostileMesh cell_block(Choices& choices, int size);
/// A conforming block of tetrahedra of exactly this size, with the given width of cells.
HostileMesh tetrahedron_block(int nx, int ny, int nz, int width = kCellWidth);

/// Elements of one type, tetrahedra or pyramids, without common vertices, in rows of 20.
HostileMesh apart(ElementType type, int count);

/// Appends the other mesh, moved by an offset, as an object. Poses are combined.
void append(HostileMesh& mesh, const HostileMesh& other, const Vec3& offset, std::int32_t object);
/// Identifies vertex b with vertex a, unless an element has both. b then has no elements.
bool join(HostileMesh& mesh, Index a, Index b);
/// Removes vertices that no element uses.
void remove_unused_vertices(HostileMesh& mesh);
/// Appends a block at a distance, which hardly moves, so that suspect stars and boundary elements are a small fraction.
void append_calm_block(HostileMesh& mesh, int size);

/// Adds a strip of triangles, quads, tetrahedra or hexahedra that begins with the given vertices (one or two).
void add_strip(Choices& choices, HostileMesh& mesh, std::vector<Index> root, int length);
/// Adds triangles on triangles of elements, boundary or interior.
void add_membrane(Choices& choices, HostileMesh& mesh);
/// Adds tetrahedra on faces, also inside, where a face then has three.
void add_leaves(Choices& choices, HostileMesh& mesh);
/// Removes elements at random.
void tear(Choices& choices, HostileMesh& mesh);
/// Reverses the node order of elements, or mirrors them.
void reverse_some(Choices& choices, HostileMesh& mesh);
void assign_objects(Choices& choices, HostileMesh& mesh);
/// Renumbers vertices and reorders elements; calm vertices remain the last ones.
void permute(Choices& choices, HostileMesh& mesh);

/// The integer vector nearest to p.
inline Vec3 rounded(const Vec3& p) { return p.array().round().matrix(); }

}  // namespace volccd::cases
