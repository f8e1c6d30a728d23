#include <volccd/culling/flood/detail/part_table.hpp>

#include <algorithm>
#include <functional>
#include <numeric>
#include <utility>

#include <volccd/core/heap_bytes.hpp>

namespace volccd::detail {

ElementType PartTable::type_of(const Mesh& mesh, Index o, Kind kind) {
  return kind == kWhole ? mesh.type(o) : ElementType::triangle;
}

/// The part as an element; its id is the slot of the simplex.
ElementSpec PartTable::spec_of(const Mesh& mesh, Index o, Kind kind) {
  ElementSpec part{.type = type_of(mesh, o, kind), .object = mesh.object(o), .id = o};
  const std::span<const Index> vertices = mesh.vertices(o);
  for (std::size_t i = 0; i < vertices.size(); ++i)
    if ((kind >> i & 1) != 0) part.vertices.push_back(vertices[i]);
  return part;
}

/// Makes the simplices of these parts known to adjacency().
void PartTable::set_adjacent(const Mesh& mesh, std::span<const Index> removed, std::span<const Index> added) {
  std::vector<ElementSpec> simplices;
  for (const Index part : added) simplices.push_back(spec_of(mesh, simplex_of_part_[part], kWhole));
  const auto slots = static_cast<Index>(simplex_of_part_.size());
  adjacency_.prepare(simplices, added, slots);
  adjacency_.commit(removed, simplices, added, slots);
}

void PartTable::build(const Mesh& mesh, KindOf kind_of, Executor& executor) {
  Mesh parts;
  parts.add_vertices(mesh.vertex_ids());
  kinds_.assign(mesh.element_slots(), kNoPart);
  part_of_simplex_.assign(mesh.element_slots(), kNone);
  simplex_of_part_.clear();
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (!mesh.is_live(o) || (kinds_[o] = kind_of(o)) == kNoPart) continue;
    part_of_simplex_[o] = parts.add_element(spec_of(mesh, o, kinds_[o]));
    simplex_of_part_.push_back(o);
  }
  parts_.emplace(std::move(parts), executor, EdgeSet::none);
  adjacency_ = Adjacency();
  std::vector<Index> all(simplex_of_part_.size());
  std::iota(all.begin(), all.end(), Index{0});
  set_adjacent(mesh, {}, all);
}

/// Whether the part is in the table already, of the same simplex with the same object.
bool PartTable::is_listed(const Mesh& mesh, Index o, Kind kind) const {
  if (kinds_[o] != kind) return false;
  if (kind == kNoPart) return true;
  const Index listed = part_of_simplex_[o];
  const std::span<const Index> simplex = mesh.vertices(o);
  return parts_->mesh().type(listed) == type_of(mesh, o, kind) && parts_->mesh().object(listed) == mesh.object(o) &&
         std::equal(simplex.begin(), simplex.end(), adjacency_.vertices(listed).begin());
}

void PartTable::update(const Mesh& mesh, std::span<const Index> slots, KindOf kind_of) {
  kinds_.resize(mesh.element_slots(), kNoPart);
  part_of_simplex_.resize(mesh.element_slots(), kNone);
  TopologyEdit edit;
  edit.new_vertex_ids.assign(mesh.vertex_ids().begin() + parts_->mesh().vertex_count(), mesh.vertex_ids().end());
  std::vector<Index> fresh;  // simplices that had no part
  for (const Index o : slots) {
    const Kind kind = mesh.is_live(o) ? kind_of(o) : kNoPart;
    if (is_listed(mesh, o, kind)) continue;
    kinds_[o] = kind;
    if (part_of_simplex_[o] != kNone)
      edit.removed.push_back(std::exchange(part_of_simplex_[o], kNone));
    else
      fresh.push_back(o);
  }
  // A topology gives the slots of removed elements, in descending order, to the added ones. A simplex with another part
  // keeps its slot, and with it the place of the part in a tree.
  std::sort(edit.removed.begin(), edit.removed.end(), std::greater());
  const auto add = [&](Index o) { edit.added.push_back(spec_of(mesh, o, kinds_[o])); };
  for (const Index part : edit.removed) {
    if (const Index o = simplex_of_part_[part]; kinds_[o] != kNoPart) {
      add(o);
    } else if (!fresh.empty()) {
      add(fresh.back());
      fresh.pop_back();
    }
  }
  std::for_each(fresh.begin(), fresh.end(), add);
  if (edit.empty()) return;
  const TopologyChange& change = parts_->apply(edit);
  for (const Index part : change.removed_elements) simplex_of_part_[part] = kNone;
  simplex_of_part_.resize(parts_->mesh().element_slots(), kNone);
  for (const Index part : change.added_elements) {
    simplex_of_part_[part] = static_cast<Index>(parts_->mesh().element_id(part));
    part_of_simplex_[simplex_of_part_[part]] = part;
  }
  set_adjacent(mesh, change.removed_elements, change.added_elements);
}

std::size_t PartTable::bytes() const {
  return (parts_ ? parts_->bytes() : 0) + heap_bytes(part_of_simplex_, simplex_of_part_, adjacency_, kinds_);
}

}  // namespace volccd::detail
