#include <volccd/mesh/mesh.hpp>

#include <cassert>
#include <limits>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/core/random.hpp>
#include <volccd/mesh/check_element.hpp>
#include <volccd/mesh/tables/raw_vector.hpp>

namespace volccd {

namespace {

std::uint32_t id_hash(std::int64_t id) { return static_cast<std::uint32_t>(mix(static_cast<std::uint64_t>(id)) >> 32); }

void check_vertex_number(std::size_t n) {
  if (n >= kNone) throw InputError("mesh", "vertex ids", "more than 2^32 - 2 vertices");
}

}  // namespace

void Mesh::add_vertices(std::span<const std::int64_t> ids) {
  check_vertex_number(vertex_ids_.size() + ids.size());
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (i == 0 && vertex_ids_.empty()) continue;
    const std::int64_t before = i == 0 ? vertex_ids_.back() : ids[i - 1];
    if (ids[i] <= before)
      throw InputError("mesh", "vertex ids", static_cast<std::int64_t>(i),
                       fmt::format("ids must ascend, but {} follows {}", ids[i], before));
  }
  vertex_ids_.insert(vertex_ids_.end(), ids.begin(), ids.end());
}

void Mesh::add_vertices(Index n) {
  check_vertex_number(vertex_ids_.size() + n);
  const std::int64_t last = vertex_ids_.empty() ? -1 : vertex_ids_.back();
  if (last > std::numeric_limits<std::int64_t>::max() - n)
    throw InputError("mesh", "vertex ids", "no ids are left above the last vertex");
  detail::reserve_more(vertex_ids_, n);
  for (Index i = 1; i <= n; ++i) vertex_ids_.push_back(last + i);
}

Index Mesh::add_element(const ElementSpec& element) {
  if (const std::string problem = detail::element_problem(element, vertex_count()); !problem.empty())
    throw InputError("mesh", "elements", element.id, problem);
  if (free_slots_.empty() && types_.size() + 1 >= kNone)
    throw InputError("mesh", "elements", element.id, "more than 2^32 - 2 elements");
  if (find_element(element.id) != kNone)
    throw InputError("mesh", "elements", element.id, "another element has this id");
  const std::size_t length = element.vertices.size() + element.faces.size();
  const auto blocks = free_blocks_.find(length);
  const bool block_free = blocks != free_blocks_.end() && !blocks->second.empty();
  reserve_slots(free_slots_.empty() ? 1 : 0, 1, block_free ? 0 : length);
  return place(element);
}

void Mesh::remove_element(Index slot) {
  assert(slot < element_slots() && is_live(slot));
  const Block& block = blocks_[slot];
  std::vector<std::size_t>& starts = free_blocks_[std::size_t{block.vertices} + block.faces];
  detail::reserve_more(starts, 1);
  detail::reserve_more(free_slots_, 1);
  id_table_.erase(slot, [&](Index other) { return id_hash(element_ids_[other]); });
  starts.push_back(block.begin);
  types_[slot] = ElementType::none;
  free_slots_.push_back(slot);
  --live_;
}

std::vector<Index> Mesh::prepare(std::span<const Index> removed, std::size_t new_vertices,
                                 std::span<const ElementSpec> added) {
  std::map<std::size_t, std::size_t> freed, taken;  // numbers of blocks, by length
  for (const Index o : removed) ++freed[std::size_t{blocks_[o].vertices} + blocks_[o].faces];
  for (const ElementSpec& element : added) ++taken[element.vertices.size() + element.faces.size()];
  for (const auto& [length, n] : freed) detail::reserve_more(free_blocks_[length], n);
  std::size_t connectivity = 0;
  for (const auto& [length, n] : taken) {
    const auto free = free_blocks_.find(length);
    const std::size_t there = (free == free_blocks_.end() ? 0 : free->second.size()) + freed[length];
    if (n > there) connectivity += (n - there) * length;
  }
  detail::reserve_more(vertex_ids_, new_vertices);
  detail::reserve_more(free_slots_, removed.size());
  const std::size_t free_slots = free_slots_.size() + removed.size();
  reserve_slots(added.size() > free_slots ? added.size() - free_slots : 0,
                added.size() > removed.size() ? added.size() - removed.size() : 0, connectivity);

  std::vector<Index> slots;
  slots.reserve(added.size());
  for (std::size_t i = 0; i < added.size(); ++i)
    slots.push_back(i < removed.size() ? removed[removed.size() - 1 - i]
                    : i < free_slots   ? free_slots_[free_slots - 1 - i]
                                       : static_cast<Index>(types_.size() + (i - free_slots)));
  return slots;
}

void Mesh::commit(std::span<const Index> removed, std::span<const std::int64_t> new_vertex_ids,
                  std::span<const ElementSpec> added) noexcept {
  for (const Index o : removed) remove_element(o);
  vertex_ids_.insert(vertex_ids_.end(), new_vertex_ids.begin(), new_vertex_ids.end());
  for (const ElementSpec& element : added) place(element);
}

/// Reserves memory for more slots, ids and entries of connectivity_.
void Mesh::reserve_slots(std::size_t slots, std::size_t ids, std::size_t connectivity) {
  detail::reserve_more(types_, slots);
  detail::reserve_more(objects_, slots);
  detail::reserve_more(element_ids_, slots);
  detail::reserve_more(blocks_, slots);
  detail::reserve_more(connectivity_, connectivity);
  id_table_.reserve_more(ids, [&](Index other) { return id_hash(element_ids_[other]); });
}

/// Stores a valid element, for which memory has been reserved.
Index Mesh::place(const ElementSpec& element) noexcept {
  const Index slot = free_slots_.empty() ? element_slots() : free_slots_.back();
  if (free_slots_.empty()) {
    types_.push_back(ElementType::none);
    objects_.push_back(0);
    element_ids_.push_back(0);
    blocks_.push_back({});
  } else {
    free_slots_.pop_back();
  }
  id_table_.find_or_insert(
      id_hash(element.id), slot, [](Index) { return false; },
      [&](Index other) { return id_hash(element_ids_[other]); });
  types_[slot] = element.type;
  objects_[slot] = element.object;
  element_ids_[slot] = element.id;
  ids_ascend_ = ids_ascend_ && (slot == 0 || element_ids_[slot - 1] < element.id) &&
                (slot + 1 == element_ids_.size() || element.id < element_ids_[slot + 1]);
  const std::size_t begin = allocate(element.vertices.size() + element.faces.size());
  blocks_[slot] = {begin, static_cast<Index>(element.vertices.size()), static_cast<Index>(element.faces.size())};
  const auto to = connectivity_.begin() + static_cast<std::ptrdiff_t>(begin);
  std::copy(element.faces.begin(), element.faces.end(),
            std::copy(element.vertices.begin(), element.vertices.end(), to));
  ++live_;
  return slot;
}

ElementSpec Mesh::spec(Index o) const {
  const std::span<const Index> nodes = vertices(o), faces = polytope_faces(o);
  return {.type = types_[o],
          .vertices = {nodes.begin(), nodes.end()},
          .faces = {faces.begin(), faces.end()},
          .object = objects_[o],
          .id = element_ids_[o]};
}

Index Mesh::find_element(std::int64_t id) const {
  return id_table_.find(id_hash(id), [&](Index slot) { return element_ids_[slot] == id; });
}

std::size_t Mesh::allocate(std::size_t length) noexcept {
  if (const auto found = free_blocks_.find(length); found != free_blocks_.end() && !found->second.empty()) {
    const std::size_t begin = found->second.back();
    found->second.pop_back();
    return begin;
  }
  const std::size_t begin = connectivity_.size();
  connectivity_.resize(begin + length);
  return begin;
}

std::size_t Mesh::bytes() const {
  std::size_t total =
      heap_bytes(id_table_, vertex_ids_, types_, objects_, element_ids_, blocks_, connectivity_, free_slots_);
  for (const auto& [length, starts] : free_blocks_) total += heap_bytes(starts);
  return total;
}

}  // namespace volccd
