#include <volccd/culling/detail/outer_parts.hpp>

#include <algorithm>
#include <iterator>

#include <volccd/core/sort_unique.hpp>

namespace volccd::detail {

namespace {

/// The part of a simplex that the topology determines: with the kinds of its faces, and without regard to motion.
std::uint8_t boundary_part_of(const Mesh& mesh, const StarTable& table, Index o) {
  const std::span<const Index> vertices = mesh.vertices(o);
  if (!mesh.is_live(o)) return ElementSubset::kNoPart;
  const bool irregular = std::any_of(vertices.begin(), vertices.end(),
                                     [&](Index v) { return table.kind(v) == StarKind::irregular; });
  if (mesh.type(o) != ElementType::tetrahedron || irregular) return ElementSubset::kWhole;
  std::uint8_t part = ElementSubset::kNoPart;
  visit_faces(mesh, o, [&](std::span<const Index> face, std::size_t number) {
    if (table.faces(o)[number] != FaceKind::boundary) return;
    std::uint8_t bits = 0;
    for (std::size_t i = 0; i < 4; ++i)
      if (std::find(face.begin(), face.end(), vertices[i]) != face.end()) bits |= static_cast<std::uint8_t>(1u << i);
    part = part == ElementSubset::kNoPart ? bits : ElementSubset::kWhole;
  });
  return part;
}

}  // namespace

void OuterParts::set_boundary_parts(const Step& step, const StarTable& table) {
  const Mesh& mesh = step.mesh();
  boundary_parts_.resize(mesh.element_slots());
  for (Index o = 0; o < boundary_parts_.size(); ++o) boundary_parts_[o] = boundary_part_of(mesh, table, o);
}

/// Finds the smallest vertex of each set of boundary parts that is connected by common vertices.
void OuterParts::find_components(const Step& step) {
  const Mesh& mesh = step.mesh();
  parents_.assign(mesh.vertex_count(), kNone);  // kNone: a vertex of no boundary part
  const auto root = [&](Index v) {
    while (parents_[v] != v) v = parents_[v] = parents_[parents_[v]];
    return v;
  };
  for (Index o = 0; o < boundary_parts_.size(); ++o) {
    const std::span<const Index> vertices = mesh.vertices(o);
    Index first = kNone;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      if ((boundary_parts_[o] >> i & 1) == 0) continue;
      const Index v = vertices[i];
      if (parents_[v] == kNone) parents_[v] = v;
      if (first == kNone) first = v;
      const Index x = root(v), y = root(first);
      parents_[std::max(x, y)] = std::min(x, y);
    }
  }
  components_.clear();
  for (Index v = 0; v < parents_.size(); ++v)
    if (parents_[v] == v) components_.push_back(v);
}

std::uint8_t OuterParts::part_of(const Mesh& mesh, const VertexStars& stars, Index o) const {
  if (!mesh.is_live(o)) return ElementSubset::kNoPart;
  const std::span<const Index> vertices = mesh.vertices(o);
  const bool suspect = std::any_of(vertices.begin(), vertices.end(), [&](Index v) { return stars.suspect(v); });
  return suspect ? ElementSubset::kWhole : boundary_parts_[o];
}

/// A component of S without a boundary part consists of elements at suspect vertices. Such a vertex is chosen if no
/// vertex of its star is on a boundary part; otherwise its component contains that part.
void OuterParts::choose_vertices(const Step& step, const VertexStars& stars) {
  chosen_ = components_;
  const auto inner = [&](Index v) { return stars.table().kind(v) == StarKind::interior; };
  for (const Index v : stars.suspects()) {
    const std::span<const Index> star = step.features().vertex_elements(v);
    const bool apart = std::all_of(star.begin(), star.end(), [&](Index o) {
      const std::span<const Index> vertices = step.mesh().vertices(o);
      return std::all_of(vertices.begin(), vertices.end(), inner);
    });
    if (apart) chosen_.push_back(v);
  }
  sort_unique(chosen_);
}

void OuterParts::update(const Step& step, const VertexStars& stars) {
  const Mesh& mesh = step.mesh();
  const TopologyDelta::Extent changed = delta_.sync(step.topology);
  const auto part = [&](Index o) { return part_of(mesh, stars, o); };
  if (changed != TopologyDelta::Extent::none) {
    set_boundary_parts(step, stars.table());
    find_components(step);
    if (changed == TopologyDelta::Extent::everything) subset_.clear();
    subset_.assign(mesh, part);
  } else {
    std::vector<Index>& vertices = chosen_;  // those that became suspect or clear
    vertices.clear();
    std::set_symmetric_difference(suspects_.begin(), suspects_.end(), stars.suspects().begin(), stars.suspects().end(),
                                  std::back_inserter(vertices));
    slots_.clear();
    for (const Index v : vertices)
      for (const Index o : step.features().vertex_elements(v)) slots_.push_back(o);
    sort_unique(slots_);
    subset_.assign(mesh, slots_, part);
  }
  suspects_ = stars.suspects();
  choose_vertices(step, stars);
  delta_.confirm();
}

}  // namespace volccd::detail
