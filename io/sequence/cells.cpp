#include <volccd/io/sequence/cells.hpp>

#include <algorithm>

#include <volccd/mesh/edit_between.hpp>

namespace volccd {

namespace {

bool same_element(const Mesh& mesh, Index o, const SequenceCells& cells, std::size_t i) {
  return mesh.type(o) == cells.types[i] && mesh.object(o) == cells.objects[i] &&
         std::ranges::equal(mesh.vertices(o), cells.vertices(i)) &&
         std::ranges::equal(mesh.polytope_faces(o), cells.face_stream(i));
}

}  // namespace

ElementSpec SequenceCells::spec(std::size_t i) const {
  const std::span<const Index> nodes = vertices(i), stream = face_stream(i);
  return {.type = types[i],
          .vertices = {nodes.begin(), nodes.end()},
          .faces = {stream.begin(), stream.end()},
          .object = objects[i],
          .id = ids[i]};
}

void SequenceCells::add(const ElementSpec& element) {
  if (element.type == ElementType::polytope && face_offsets.empty()) face_offsets.assign(size() + 1, 0);
  types.push_back(element.type);
  connectivity.insert(connectivity.end(), element.vertices.begin(), element.vertices.end());
  offsets.push_back(connectivity.size());
  objects.push_back(element.object);
  ids.push_back(element.id);
  if (face_offsets.empty()) return;
  if (element.type == ElementType::polytope) faces.insert(faces.end(), element.faces.begin(), element.faces.end());
  face_offsets.push_back(faces.size());
}

void SequenceCells::clear() {
  types.clear();
  offsets.assign(1, 0);
  connectivity.clear();
  objects.clear();
  ids.clear();
  face_offsets.clear();
  faces.clear();
}

SequenceCells cells_of(const Mesh& mesh) {
  SequenceCells cells;
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.is_live(o)) cells.add(mesh.spec(o));
  return cells;
}

Mesh mesh_of(std::span<const std::int64_t> point_ids, const SequenceCells& cells) {
  Mesh mesh;
  mesh.add_vertices(point_ids);
  for (std::size_t i = 0; i < cells.size(); ++i) mesh.add_element(cells.spec(i));
  return mesh;
}

TopologyEdit edit_to(const Mesh& mesh, const SequenceCells& cells) {
  return edit_between(
      mesh, cells.size(), [&](std::size_t i) { return cells.ids[i]; },
      [&](std::size_t i, Index o) { return same_element(mesh, o, cells, i); },
      [&](std::size_t i) { return cells.spec(i); });
}

}  // namespace volccd
