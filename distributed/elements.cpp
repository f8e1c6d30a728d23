#include <volccd/distributed/elements.hpp>

namespace volccd::distributed {

void Elements::add(ElementType type, std::span<const std::int64_t> vertex_ids, std::int32_t object, std::int64_t id,
                   std::span<const std::int64_t> face_stream) {
  types.push_back(type);
  objects.push_back(object);
  ids.push_back(id);
  vertices.insert(vertices.end(), vertex_ids.begin(), vertex_ids.end());
  offsets.push_back(vertices.size());
  faces.insert(faces.end(), face_stream.begin(), face_stream.end());
  face_offsets.push_back(faces.size());
}

void Elements::add(const Mesh& mesh, Index element) {
  types.push_back(mesh.type(element));
  objects.push_back(mesh.object(element));
  ids.push_back(mesh.element_id(element));
  for (const Index v : mesh.vertices(element)) vertices.push_back(mesh.vertex_id(v));
  offsets.push_back(vertices.size());
  Index rest = 0;  // of the present face
  for (const Index v : mesh.polytope_faces(element)) {
    faces.push_back(rest == 0 ? std::int64_t{v} : mesh.vertex_id(v));
    rest = rest == 0 ? v : rest - 1;
  }
  face_offsets.push_back(faces.size());
}

void Elements::add(const Elements& others, std::size_t i) {
  add(others.types[i], others.vertices_of(i), others.objects[i], others.ids[i], others.faces_of(i));
}

}  // namespace volccd::distributed
