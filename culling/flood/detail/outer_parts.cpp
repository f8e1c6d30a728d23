#include <volccd/culling/flood/detail/outer_parts.hpp>

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

#include <volccd/core/sort_unique.hpp>

namespace volccd::detail {

namespace {

using Kind = PartTable::Kind;

/// Up to this many vertices without a suspect star remain marked, besides as many as have one.
constexpr std::size_t kMaxFormerSuspects = 256;

/// The part of a simplex that the topology determines: with the kinds of its faces, and without regard to marks.
Kind boundary_kind(const Mesh& mesh, const StarTable& table, Index o) {
  const std::span<const Index> vertices = mesh.vertices(o);
  if (!mesh.is_live(o)) return PartTable::kNoPart;
  if (mesh.type(o) != ElementType::tetrahedron) return PartTable::kWhole;
  Kind kind = PartTable::kNoPart;
  visit_faces(mesh, o, [&](std::span<const Index> face, std::size_t number) {
    if (table.faces(o)[number] != FaceKind::boundary) return;
    Kind bits = 0;
    for (std::size_t i = 0; i < 4; ++i)
      if (std::find(face.begin(), face.end(), vertices[i]) != face.end()) bits |= static_cast<Kind>(1u << i);
    kind = kind == PartTable::kNoPart ? bits : PartTable::kWhole;
  });
  return kind;
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
  for (Index o = 0; o < boundary_kinds_.size(); ++o) {
    const std::span<const Index> vertices = mesh.vertices(o);
    Index first = kNone;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      if ((boundary_kinds_[o] >> i & 1) == 0) continue;
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

/// A component of S without a boundary part consists of elements at marked vertices. Such a vertex is chosen if no
/// vertex of its star is on a boundary part; otherwise its component contains that part.
void OuterParts::choose_vertices(const Step& step) {
  chosen_ = components_;
  const auto inner = [&](Index v) { return parents_[v] == kNone; };  // of no boundary part
  for (const Index v : marked_) {
    const std::span<const Index> star = step.features().vertex_elements(v);
    const bool apart = std::all_of(star.begin(), star.end(), [&](Index o) {
      const std::span<const Index> vertices = step.mesh().vertices(o);
      return std::all_of(vertices.begin(), vertices.end(), inner);
    });
    if (apart) chosen_.push_back(v);
  }
  sort_unique(chosen_);
}

/// Marks the vertices with suspect stars, and sets vertices_ to those that became marked or unmarked. After an edit,
/// which changes parts in any case, no other vertices remain marked.
void OuterParts::mark_vertices(const Step& step, const VertexStars& stars, bool edited) {
  const std::vector<Index>& suspects = stars.suspects();
  is_marked_.resize(step.mesh().vertex_count(), 0);
  vertices_.clear();
  std::set_difference(suspects.begin(), suspects.end(), marked_.begin(), marked_.end(), std::back_inserter(vertices_));
  if (edited || marked_.size() + vertices_.size() > 2 * suspects.size() + kMaxFormerSuspects) {
    vertices_.clear();
    std::set_symmetric_difference(suspects.begin(), suspects.end(), marked_.begin(), marked_.end(),
                                  std::back_inserter(vertices_));
    marked_ = suspects;
  } else if (!vertices_.empty()) {
    marked_.insert(marked_.end(), vertices_.begin(), vertices_.end());
    std::sort(marked_.begin(), marked_.end());
  }
  for (const Index v : vertices_) is_marked_[v] = std::binary_search(marked_.begin(), marked_.end(), v);
}

/// Sets slots_ to the elements whose parts may have changed: those at vertices that became marked or unmarked, and
/// those at vertices whose elements changed.
void OuterParts::find_changed_slots(const Step& step) {
  slots_ = delta_.changed_slots();
  for (const TopologyChange* change : delta_.changes()) {
    append_stars(step.features(), change->features.added_vertices, slots_);
    append_stars(step.features(), change->features.touched_vertices, slots_);
  }
  append_stars(step.features(), vertices_, slots_);
  sort_unique(slots_);
}

void OuterParts::update(const Step& step, const VertexStars& stars, Executor& executor) {
  const Mesh& mesh = step.mesh();
  const TopologyDelta::Extent changed = delta_.sync(step.topology);
  const bool everything = changed == TopologyDelta::Extent::everything;
  if (everything) is_marked_.clear(), marked_.clear();
  mark_vertices(step, stars, changed != TopologyDelta::Extent::none);
  if (everything) {
    slots_.resize(mesh.element_slots());
    std::iota(slots_.begin(), slots_.end(), Index{0});
  } else {
    find_changed_slots(step);
  }
  if (changed != TopologyDelta::Extent::none) {
    boundary_kinds_.resize(mesh.element_slots());
    for (const Index o : slots_) boundary_kinds_[o] = boundary_kind(mesh, stars.table(), o);
    find_components(step);
  }
  const auto kind_of = [&](Index o) {
    const std::span<const Index> vertices = mesh.vertices(o);
    const bool marked = std::any_of(vertices.begin(), vertices.end(), [&](Index v) { return is_marked_[v] != 0; });
    return marked ? PartTable::kWhole : boundary_kinds_[o];
  };
  everything ? table_.build(mesh, kind_of, executor) : table_.update(mesh, slots_, kind_of);
  choose_vertices(step);
  delta_.confirm();
}

}  // namespace volccd::detail
