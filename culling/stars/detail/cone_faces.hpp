// The faces of elements, each with the corners whose cones are over it.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include <volccd/mesh/element_type.hpp>

namespace volccd::detail {

/// A face, and the corners of the element that are not on it, as local vertex numbers.
struct ConeFace {
  std::uint8_t size = 0, corner_count = 0;
  std::array<std::uint8_t, 4> vertices{}, corners{};
};
struct ConeFaces {
  std::uint8_t vertices = 0, count = 0;
  std::array<ConeFace, 6> faces{};
};

inline ConeFaces make_cone_faces(ElementType type) {
  ConeFaces found;
  found.vertices = static_cast<std::uint8_t>(vertex_count(type));
  volccd::visit_faces(face_stream(type), [&](std::span<const std::uint8_t> vertices) {
    ConeFace& face = found.faces[found.count++];
    face.size = static_cast<std::uint8_t>(vertices.size());
    std::copy(vertices.begin(), vertices.end(), face.vertices.begin());
    for (std::uint8_t v = 0; v < found.vertices; ++v)
      if (std::find(vertices.begin(), vertices.end(), v) == vertices.end()) face.corners[face.corner_count++] = v;
  });
  return found;
}

/// Null for types without cones, and for tetrahedra, whose cones are the tetrahedron.
inline const ConeFaces* cone_faces(ElementType type) {
  static const ConeFaces hexahedron = make_cone_faces(ElementType::hexahedron),
                         wedge = make_cone_faces(ElementType::wedge), pyramid = make_cone_faces(ElementType::pyramid);
  switch (type) {
    case ElementType::hexahedron: return &hexahedron;
    case ElementType::wedge: return &wedge;
    case ElementType::pyramid: return &pyramid;
    default: return nullptr;
  }
}

}  // namespace volccd::detail
