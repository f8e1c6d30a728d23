// Elements of a mesh of which no rank has all, named by ids.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/mesh/element_type.hpp>
#include <volccd/mesh/mesh.hpp>

namespace volccd::distributed {

/// Elements in CSR form, whose vertices are named by 64-bit ids. One array for each property, by element; ranges are
/// those between consecutive offsets.
struct Elements {
  std::vector<ElementType> types;
  std::vector<std::int32_t> objects;
  std::vector<std::int64_t> ids;
  std::vector<std::size_t> offsets{0};       ///< size() + 1 positions in `vertices`
  std::vector<std::int64_t> vertices;        ///< ids in VTK node order; a polytope's distinct vertices
  std::vector<std::size_t> face_offsets{0};  ///< size() + 1 positions in `faces`
  std::vector<std::int64_t> faces;           ///< for each polytope {n, v0 .. v(n-1), n, ...}, vertex ids

  std::size_t size() const { return types.size(); }
  std::span<const std::int64_t> vertices_of(std::size_t i) const {
    return std::span(vertices).subspan(offsets[i], offsets[i + 1] - offsets[i]);
  }
  /// Empty if element i is not a polytope.
  std::span<const std::int64_t> faces_of(std::size_t i) const {
    return std::span(faces).subspan(face_offsets[i], face_offsets[i + 1] - face_offsets[i]);
  }

  /// Appends an element.
  void add(ElementType type, std::span<const std::int64_t> vertex_ids, std::int32_t object, std::int64_t id,
           std::span<const std::int64_t> face_stream = {});
  /// Appends an element of a mesh.
  void add(const Mesh& mesh, Index element);
  /// Appends element i of others.
  void add(const Elements& others, std::size_t i);

  /// Element i for a mesh in which vertex id v has the slot slot_of(v).
  template <class SlotOf>
  ElementSpec spec(std::size_t i, SlotOf&& slot_of) const {
    ElementSpec result{.type = types[i], .object = objects[i], .id = ids[i]};
    for (const std::int64_t v : vertices_of(i)) result.vertices.push_back(slot_of(v));
    std::size_t rest = 0;  // of the present face
    for (const std::int64_t v : faces_of(i)) {
      result.faces.push_back(rest == 0 ? static_cast<Index>(v) : slot_of(v));
      rest = rest == 0 ? static_cast<std::size_t>(v) : rest - 1;
    }
    return result;
  }
};

}  // namespace volccd::distributed
