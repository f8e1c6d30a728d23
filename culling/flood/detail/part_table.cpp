#include <volccd/culling/flood/detail/part_table.hpp>

#include <utility>

#include <volccd/core/heap_bytes.hpp>

namespace volccd::detail {

/// The part as an element; its id is the slot of the simplex.
ElementSpec PartTable::spec_of(const Mesh& mesh, Index o, Kind kind) {
  ElementSpec part{.type = kind == kWhole ? mesh.type(o) : ElementType::triangle, .object = mesh.object(o), .id = o};
  const std::span<const Index> vertices = mesh.vertices(o);
  for (std::size_t i = 0; i < vertices.size(); ++i)
    if ((kind >> i & 1) != 0) part.vertices.push_back(vertices[i]);
  return part;
}

std::array<Index, 4> PartTable::corners_of(const Mesh& mesh, Index o) {
  const std::span<const Index> vertices = mesh.vertices(o);
  std::array<Index, 4> corners;
  std::fill(std::copy(vertices.begin(), vertices.end(), corners.begin()), corners.end(), vertices[0]);
  return corners;
}

void PartTable::build(const Mesh& mesh, KindOf kind_of, Executor& executor) {
  Mesh parts;
  parts.add_vertices(mesh.vertex_ids());
  kinds_.assign(mesh.element_slots(), kNoPart);
  part_of_simplex_.assign(mesh.element_slots(), kNone);
  simplex_of_part_.clear();
  corners_.clear();
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (!mesh.is_live(o) || (kinds_[o] = kind_of(o)) == kNoPart) continue;
    part_of_simplex_[o] = parts.add_element(spec_of(mesh, o, kinds_[o]));
    simplex_of_part_.push_back(o);
    corners_.push_back(corners_of(mesh, o));
  }
  parts_.emplace(std::move(parts), executor, EdgeSet::none);
}

/// Whether the part is in the table already, with the same vertices and the same object.
bool PartTable::is_listed(const Mesh& mesh, Index o, Kind kind) const {
  if (kinds_[o] != kind) return false;
  if (kind == kNoPart) return true;
  const Index listed = part_of_simplex_[o];
  const ElementSpec part = spec_of(mesh, o, kind);
  return parts_->mesh().type(listed) == part.type && parts_->mesh().object(listed) == part.object &&
         std::ranges::equal(parts_->mesh().vertices(listed), part.vertices);
}

void PartTable::update(const Mesh& mesh, std::span<const Index> slots, KindOf kind_of) {
  kinds_.resize(mesh.element_slots(), kNoPart);
  part_of_simplex_.resize(mesh.element_slots(), kNone);
  TopologyEdit edit;
  edit.new_vertex_ids.assign(mesh.vertex_ids().begin() + parts_->mesh().vertex_count(), mesh.vertex_ids().end());
  for (const Index o : slots) {
    const Kind kind = mesh.is_live(o) ? kind_of(o) : kNoPart;
    if (is_listed(mesh, o, kind)) {
      if (kind != kNoPart) corners_[part_of_simplex_[o]] = corners_of(mesh, o);  // a face may be of another simplex now
      continue;
    }
    if (part_of_simplex_[o] != kNone) edit.removed.push_back(std::exchange(part_of_simplex_[o], kNone));
    kinds_[o] = kind;
    if (kind != kNoPart) edit.added.push_back(spec_of(mesh, o, kind));
  }
  if (edit.empty()) return;
  const TopologyChange& change = parts_->apply(edit);
  for (const Index part : change.removed_elements) simplex_of_part_[part] = kNone;
  simplex_of_part_.resize(parts_->mesh().element_slots(), kNone);
  corners_.resize(parts_->mesh().element_slots());
  for (const Index part : change.added_elements) {
    simplex_of_part_[part] = static_cast<Index>(parts_->mesh().element_id(part));
    part_of_simplex_[simplex_of_part_[part]] = part;
    corners_[part] = corners_of(mesh, simplex_of_part_[part]);
  }
}

std::size_t PartTable::bytes() const {
  return (parts_ ? parts_->bytes() : 0) + heap_bytes(part_of_simplex_, simplex_of_part_, corners_, kinds_);
}

}  // namespace volccd::detail
