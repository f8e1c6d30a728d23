#include <volccd/culling/flood/detail/outer_parts.hpp>

#include <algorithm>
#include <iterator>
#include <numeric>

#include <volccd/core/sort_unique.hpp>

namespace volccd::detail {

namespace {

/// The part of a simplex that the topology determines: with the kinds of its faces, and without regard to motion.
std::uint8_t boundary_part_of(const Mesh& mesh, const StarTable& table, Index o) {
  const std::span<const Index> vertices = mesh.vertices(o);
  if (!mesh.is_live(o)) return ElementSubset::kNoPart;
  const bool irregular =
      std::any_of(vertices.begin(), vertices.end(), [&](Index v) { return table.kind(v) == StarKind::irregular; });
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

/// Appends the elements at the vertices.
void append_stars(const Features& features, std::span<const Index> vertices, std::vector<Index>& slots) {
  for (const Index v : vertices) {
    const std::span<const Index> star = features.vertex_elements(v);
    slots.insert(slots.end(), star.begin(), star.end());
  }
}

}  // namespace

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

/// Sets slots_ to the elements whose parts may have changed: those at vertices that became suspect or clear, and those
/// at vertices whose elements changed.
void OuterParts::find_changed_slots(const Step& step, const VertexStars& stars) {
  slots_ = delta_.changed_slots();
  for (const TopologyChange* change : delta_.changes()) {
    append_stars(step.features(), change->features.added_vertices, slots_);
    append_stars(step.features(), change->features.touched_vertices, slots_);
  }
  std::vector<Index>& vertices = chosen_;  // scratch memory
  vertices.clear();
  std::set_symmetric_difference(suspects_.begin(), suspects_.end(), stars.suspects().begin(), stars.suspects().end(),
                                std::back_inserter(vertices));
  append_stars(step.features(), vertices, slots_);
  sort_unique(slots_);
}

void OuterParts::update(const Step& step, const VertexStars& stars) {
  const Mesh& mesh = step.mesh();
  const TopologyDelta::Extent changed = delta_.sync(step.topology);
  if (changed == TopologyDelta::Extent::everything) {
    subset_.clear();
    slots_.resize(mesh.element_slots());
    std::iota(slots_.begin(), slots_.end(), Index{0});
  } else {
    find_changed_slots(step, stars);
  }
  if (changed != TopologyDelta::Extent::none) {
    boundary_parts_.resize(mesh.element_slots());
    for (const Index o : slots_) boundary_parts_[o] = boundary_part_of(mesh, stars.table(), o);
    find_components(step);
  }
  subset_.assign(mesh, slots_, [&](Index o) { return part_of(mesh, stars, o); });
  suspects_ = stars.suspects();
  choose_vertices(step, stars);
  delta_.confirm();
}

}  // namespace volccd::detail
