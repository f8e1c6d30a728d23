#include <volccd/distributed/piece_mesh.hpp>

#include <algorithm>

namespace volccd::distributed {

void PieceMesh::update(const Topology& whole, std::span<const Index> elements, Index vertex_group, Executor& executor) {
  if (topology_ && whole_version_ == whole.version() && vertex_group_ == vertex_group &&
      elements_.size() <= elements.size() + elements.size() / 4 && std::ranges::includes(elements_, elements))
    return;
  topology_.reset();  // if the rest throws, the next update builds the piece
  elements_.assign(elements.begin(), elements.end());
  vertex_group_ = vertex_group;
  build(whole, executor);
  whole_version_ = whole.version();
}

void PieceMesh::build(const Topology& whole, Executor& executor) {
  const Mesh& mesh = whole.mesh();
  std::vector<Index> slot_of(mesh.vertex_count(), kNone);
  for (const Index o : elements_)
    for (const Index v : mesh.vertices(o))
      for (Index i = 0, first = v / vertex_group_ * vertex_group_; i < vertex_group_; ++i) slot_of[first + i] = 0;
  vertices_.clear();
  std::vector<std::int64_t> ids;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    if (slot_of[v] == kNone) continue;
    slot_of[v] = static_cast<Index>(vertices_.size());
    vertices_.push_back(v);
    ids.push_back(mesh.vertex_id(v));
  }
  Mesh piece;
  piece.add_vertices(ids);
  for (const Index o : elements_) {
    ElementSpec spec = mesh.spec(o);
    spec.renumber([&](Index v) { return slot_of[v]; });
    piece.add_element(spec);
  }
  topology_.emplace(std::move(piece), executor, whole.features().edge_set());
}

const Motion& PieceMesh::motion_of(const Motion& whole) {
  const Index count = topology_->mesh().vertex_count();
  if (motion_.vertex_count() != count || motion_.control_points() != whole.control_points())
    motion_ = Motion(count, whole.control_points());
  for (Index v = 0; v < count; ++v)
    for (int c = 0; c < whole.control_points(); ++c) motion_.set(v, c, whole.point(vertices_[v], c));
  return motion_;
}

}  // namespace volccd::distributed
