#include <volccd/experiments/harness/boundary_shells.hpp>

#include <algorithm>
#include <chrono>

#include <volccd/mesh/features.hpp>

namespace volccd {

namespace {

bool on_boundary(const Topology& mesh, Index triangle) {
  const std::span<const Index> elements = mesh.features().triangle_elements(triangle);
  const auto volumes =
      std::count_if(elements.begin(), elements.end(), [&](Index o) { return !is_shell(mesh.mesh().type(o)); });
  return volumes == 1 || static_cast<std::size_t>(volumes) < elements.size();
}

}  // namespace

void BoundaryShells::update(const Topology& mesh, const Motion& motion) {
  edit_seconds_ = 0;
  if (mesh.version() != version_) {
    const std::vector<Face> faces = faces_of(mesh);
    std::vector<std::int64_t> new_ids = add_vertices(faces, mesh.mesh().vertex_count());
    if (topology_)
      edit(faces, std::move(new_ids));
    else
      build(faces);
    version_ = mesh.version();
  }
  const Index vertices = static_cast<Index>(of_shells_.size());
  if (motion_.vertex_count() != vertices || motion_.control_points() != motion.control_points())
    motion_ = Motion(vertices, motion.control_points());
  for (Index v = 0; v < vertices; ++v)
    for (int c = 0; c < motion.control_points(); ++c) motion_.set(v, c, motion.point(of_shells_[v], c));
}

/// The boundary faces, each once, in the order of the elements.
std::vector<BoundaryShells::Face> BoundaryShells::faces_of(const Topology& mesh) const {
  const Features& features = mesh.features();
  std::vector<char> wanted(features.triangle_slots(), 0);
  for (Index f = 0; f < features.triangle_slots(); ++f) wanted[f] = on_boundary(mesh, f);
  std::vector<Face> faces;
  for (Index o = 0; o < mesh.mesh().element_slots(); ++o) {
    const std::span<const Index> own = features.own_triangles(o);
    if (std::none_of(own.begin(), own.end(), [&](Index f) { return wanted[f] != 0; })) continue;
    visit_boundary(
        mesh.mesh(), o, features.edge_set(), [](Index, Index) {},
        [&](Index a, Index b, Index c) {
          const Index f = features.find_triangle(a, b, c);
          if (wanted[f] && features.first_element_of_triangle(f) == o)
            faces.push_back({{a, b, c}, mesh.mesh().object(o), kNone});
        });
  }
  return faces;
}

/// Appends vertices that are on the boundary for the first time. Returns their ids.
std::vector<std::int64_t> BoundaryShells::add_vertices(const std::vector<Face>& faces, Index mesh_vertices) {
  std::vector<char> used(mesh_vertices, 0);
  for (const Face& face : faces)
    for (const Index v : face.oriented)
      for (Index i = 0; i < group_; ++i) used[v - v % group_ + i] = 1;
  of_mesh_.resize(mesh_vertices, kNone);
  std::vector<std::int64_t> new_ids;
  for (Index v = 0; v < mesh_vertices; ++v) {
    if (!used[v] || of_mesh_[v] != kNone) continue;
    of_mesh_[v] = static_cast<Index>(of_shells_.size());
    new_ids.push_back(of_mesh_[v]);
    of_shells_.push_back(v);
  }
  return new_ids;
}

ElementSpec BoundaryShells::element(const Face& face) {
  const Key& v = face.oriented;
  return {.type = ElementType::triangle,
          .vertices = {of_mesh_[v[0]], of_mesh_[v[1]], of_mesh_[v[2]]},
          .object = face.object,
          .id = next_id_++};
}

void BoundaryShells::build(const std::vector<Face>& faces) {
  Mesh shells;
  shells.add_vertices(static_cast<Index>(of_shells_.size()));
  for (Face face : faces) {
    face.slot = shells.add_element(element(face));
    Key key = face.oriented;
    std::sort(key.begin(), key.end());
    faces_.emplace(key, face);
  }
  topology_.emplace(std::move(shells));
}

void BoundaryShells::edit(const std::vector<Face>& faces, std::vector<std::int64_t> new_vertex_ids) {
  TopologyEdit edit;
  edit.new_vertex_ids = std::move(new_vertex_ids);
  Faces kept;
  std::vector<Key> added;
  for (const Face& face : faces) {
    Key key = face.oriented;
    std::sort(key.begin(), key.end());
    const auto known = faces_.find(key);
    if (known != faces_.end() && known->second.object == face.object) {
      kept.insert(faces_.extract(known));
      continue;
    }
    edit.added.push_back(element(face));
    kept.emplace(key, face);
    added.push_back(key);
  }
  for (const auto& [key, face] : faces_) edit.removed.push_back(face.slot);
  faces_ = std::move(kept);
  if (edit.empty()) return;
  const auto start = std::chrono::steady_clock::now();
  topology_->apply(edit);
  edit_seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  for (std::size_t i = 0; i < added.size(); ++i)
    faces_.at(added[i]).slot = topology_->mesh().find_element(edit.added[i].id);
}

}  // namespace volccd
