// Boundaries of the element types with fixed node numbers, in VTK node order. Faces are oriented outward for an element
// of positive volume.
#pragma once

#include <array>
#include <cstdint>

#include <volccd/mesh/element_type.hpp>

namespace volccd::detail {

/// Edges of the polytope (without face diagonals) and its faces, as local vertex numbers. `vertices` is 0 for types
/// without a table.
struct ElementTable {
  std::uint8_t vertices = 0, edges = 0, triangles = 0, quads = 0;
  std::array<std::array<std::uint8_t, 2>, 12> edge{};
  std::array<std::array<std::uint8_t, 3>, 4> triangle{};
  std::array<std::array<std::uint8_t, 4>, 6> quad{};
};

inline constexpr ElementTable kTriangleTable{3, 3, 1, 0, {{{0, 1}, {1, 2}, {2, 0}}}, {{{0, 1, 2}}}, {}};

inline constexpr ElementTable kQuadTable{4, 4, 0, 1, {{{0, 1}, {1, 2}, {2, 3}, {3, 0}}}, {}, {{{0, 1, 2, 3}}}};

inline constexpr ElementTable kTetrahedronTable{
    4, 6, 4, 0, {{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}}, {{{0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {0, 2, 1}}}, {}};

inline constexpr ElementTable kHexahedronTable{
    8,
    12,
    0,
    6,
    {{{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}},
    {},
    {{{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4}, {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}}}};

inline constexpr ElementTable kWedgeTable{6,
                                          9,
                                          2,
                                          3,
                                          {{{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}}},
                                          {{{0, 1, 2}, {3, 5, 4}}},
                                          {{{0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}}}};

inline constexpr ElementTable kPyramidTable{5,
                                            8,
                                            4,
                                            1,
                                            {{{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}}},
                                            {{{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}},
                                            {{{0, 3, 2, 1}}}};

inline constexpr ElementTable kNoTable{};

constexpr const ElementTable& element_table(ElementType type) {
  switch (type) {
    case ElementType::triangle: return kTriangleTable;
    case ElementType::quad: return kQuadTable;
    case ElementType::tetrahedron: return kTetrahedronTable;
    case ElementType::hexahedron: return kHexahedronTable;
    case ElementType::wedge: return kWedgeTable;
    case ElementType::pyramid: return kPyramidTable;
    case ElementType::none:
    case ElementType::polytope: break;
  }
  return kNoTable;
}

}  // namespace volccd::detail
