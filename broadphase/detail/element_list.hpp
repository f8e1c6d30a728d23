// Elements in an order of their own, with their vertices.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <volccd/mesh/adjacency.hpp>
#include <volccd/mesh/mesh.hpp>

namespace volccd::detail {

/// A view: the slots of elements by position, kNone for the gap that a removed element left, and a table with their
/// vertices. Those are not copied in the order of the list: the table has four or eight in a row by slot.
struct ElementList {
  std::span<const Index> slots;
  const Adjacency& elements;  ///< of the topology of the step

  std::size_t size() const { return slots.size(); }
  Index slot(std::size_t position) const { return slots[position]; }
  /// Vertices of the element at this position, some of them repeated. Pre: no gap.
  std::span<const Index> vertices(std::size_t position) const { return elements.vertices(slots[position]); }
};

/// Sets `slots` to those of all live elements, ascending.
void list_elements(const Mesh& mesh, std::vector<Index>& slots);

/// Removes the slots `touched` (ascending) and appends those that have a live element.
void update_elements(const Mesh& mesh, std::span<const Index> touched, std::vector<Index>& slots);

}  // namespace volccd::detail
