// Elements of mixed type in CSR form, with stable ids. Positions are not stored here but in Motion.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include <volccd/mesh/element_type.hpp>
#include <volccd/mesh/tables/slot_table.hpp>
#include <volccd/numerics/types.hpp>

namespace volccd {

/// One element as the caller describes it.
struct ElementSpec {
  ElementType type = ElementType::none;
  std::vector<Index> vertices = {};  ///< vertex slots in VTK node order; a polytope's distinct vertices
  /// Polytope only: {n, v0 .. v(n-1), n, ...}, vertex slots in cyclic order around each face.
  std::vector<Index> faces = {};
  std::int32_t object = 0;
  std::int64_t id = 0;

  /// Replaces each vertex v by slot_of(v), in the faces as well.
  template <class SlotOf>
  void renumber(SlotOf&& slot_of) {
    for (Index& v : vertices) v = slot_of(v);
    visit_faces(std::span(faces), [&](std::span<Index> face) {
      for (Index& v : face) v = slot_of(v);
    });
  }
};

/// Invariants of all members: vertex ids are strictly ascending in the slot (the vertex of smallest id has the smallest
/// slot); element ids are distinct; the vertices of one element are distinct and in range.
///
/// Removing an element empties its slot, which a later element may take. Vertices are never removed; a later element
/// may use a vertex that no element uses now. Not thread-safe during changes. A member that throws, including
/// std::bad_alloc, leaves the mesh unchanged.
class Mesh {
 public:
  Mesh() = default;

  /// Appends vertices. Throws InputError if the ids are not ascending, or not greater than all present ids.
  void add_vertices(std::span<const std::int64_t> ids);
  /// Appends n vertices with consecutive ids that follow the greatest present id.
  void add_vertices(Index n);

  /// Adds an element and returns its slot. Throws InputError if the number of vertices is wrong, a vertex is out of
  /// range or occurs twice in the element, the id is taken, or the faces of a polytope do not use exactly its vertices
  /// or are not closed (each edge in exactly two faces). Amortised O(vertices of the element).
  Index add_element(const ElementSpec& element);

  /// Removes a live element. O(1).
  void remove_element(Index slot);

  /// An edit in two phases: elements are removed, then vertices and elements are added. prepare() allocates the memory
  /// without an observable change and returns the slots of the added elements. commit() of the same edit cannot fail.
  /// Neither member performs the checks of the members above. Amortised O(vertices of the elements).
  std::vector<Index> prepare(std::span<const Index> removed, std::size_t new_vertices,
                             std::span<const ElementSpec> added);
  void commit(std::span<const Index> removed, std::span<const std::int64_t> new_vertex_ids,
              std::span<const ElementSpec> added) noexcept;

  Index vertex_count() const { return static_cast<Index>(vertex_ids_.size()); }
  std::int64_t vertex_id(Index v) const { return vertex_ids_[v]; }
  std::span<const std::int64_t> vertex_ids() const { return vertex_ids_; }

  /// Element slots are 0 .. element_slots() - 1, including empty ones.
  Index element_slots() const { return static_cast<Index>(types_.size()); }
  Index element_count() const { return live_; }
  bool is_live(Index o) const { return types_[o] != ElementType::none; }

  ElementType type(Index o) const { return types_[o]; }
  std::int32_t object(Index o) const { return objects_[o]; }
  std::int64_t element_id(Index o) const { return element_ids_[o]; }
  /// If true, live elements of greater slots have greater ids: so it is until an edit adds elements in another order.
  bool element_ids_ascend() const { return ids_ascend_; }
  /// Vertex slots in node order; empty for an empty slot.
  std::span<const Index> vertices(Index o) const {
    return {connectivity_.data() + blocks_[o].begin, types_[o] == ElementType::none ? 0u : blocks_[o].vertices};
  }
  /// The face stream of a polytope, with vertex slots; empty for other types.
  std::span<const Index> polytope_faces(Index o) const {
    return {connectivity_.data() + blocks_[o].begin + blocks_[o].vertices,
            types_[o] == ElementType::none ? 0u : blocks_[o].faces};
  }
  /// The description of a live element.
  ElementSpec spec(Index o) const;
  /// Slot of the element with this id, or kNone. Expected time O(1).
  Index find_element(std::int64_t id) const;

  std::size_t bytes() const;

 private:
  /// Position of the vertices and the face stream of an element in connectivity_.
  struct Block {
    std::size_t begin;
    Index vertices, faces;
  };
  Index place(const ElementSpec& element) noexcept;
  std::size_t allocate(std::size_t length) noexcept;
  void reserve_slots(std::size_t slots, std::size_t ids, std::size_t connectivity);

  std::vector<std::int64_t> vertex_ids_;
  std::vector<ElementType> types_;
  std::vector<std::int32_t> objects_;
  std::vector<std::int64_t> element_ids_;
  std::vector<Block> blocks_;
  std::vector<Index> connectivity_;
  std::vector<Index> free_slots_;
  /// Start positions of unused ranges of connectivity_, grouped by length.
  std::map<std::size_t, std::vector<std::size_t>> free_blocks_;
  detail::SlotTable id_table_;  ///< from element id to slot
  Index live_ = 0;
  bool ids_ascend_ = true;  ///< also with the former ids of empty slots
};

}  // namespace volccd
