// The cells of one frame of a sequence, as a file stores them and meshes are made from them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/mesh/mesh.hpp>
#include <volccd/mesh/topology.hpp>

namespace volccd {

/// Cells in file order, in CSR form. Two values are equal if they describe the same cells in the same order.
struct SequenceCells {
  std::vector<ElementType> types;
  std::vector<std::size_t> offsets{0};    ///< size() + 1 positions in connectivity
  std::vector<Index> connectivity;        ///< vertex slots in VTK node order; a polytope's distinct vertices
  std::vector<std::int32_t> objects;      ///< PartId: object of the element
  std::vector<std::int64_t> ids;          ///< GlobalCellIds: stable from frame to frame
  std::vector<std::size_t> face_offsets;  ///< size() + 1 positions in faces; empty if no cell is a polytope
  std::vector<Index> faces;               ///< for each polytope {n, v0 .. v(n-1), n, ...}, vertex slots

  std::size_t size() const { return types.size(); }
  std::span<const Index> vertices(std::size_t i) const {
    return {connectivity.data() + offsets[i], offsets[i + 1] - offsets[i]};
  }
  /// Empty if cell i is not a polytope.
  std::span<const Index> face_stream(std::size_t i) const {
    if (face_offsets.empty()) return {};
    return {faces.data() + face_offsets[i], face_offsets[i + 1] - face_offsets[i]};
  }

  ElementSpec spec(std::size_t i) const;
  void add(const ElementSpec& element);
  /// Removes all cells and keeps the memory.
  void clear();

  friend bool operator==(const SequenceCells&, const SequenceCells&) = default;
};

/// The live elements of a mesh, in ascending order of slots.
SequenceCells cells_of(const Mesh& mesh);

/// A mesh with vertices of these ids (ascending) and with these cells. Element i gets slot i. Throws the InputErrors of
/// Mesh::add_element.
Mesh mesh_of(std::span<const std::int64_t> point_ids, const SequenceCells& cells);

/// The edit that turns the elements of `mesh` into `cells`. Elements and cells correspond by id. If the type, the
/// vertices, the faces or the object of an element differ from those of the cell with the same id, the element is
/// removed and added again. Added elements are in the order of `cells`. Expected time O(elements + cells).
TopologyEdit edit_to(const Mesh& mesh, const SequenceCells& cells);

}  // namespace volccd
