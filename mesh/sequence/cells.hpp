// The cells of one step of a sequence: what a file stores, and what meshes are made from.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/mesh/mesh.hpp>
#include <volccd/mesh/topology.hpp>

namespace volccd {

/// Cells in the order of their file, in CSR form. A value: two are equal when they describe the same cells in the same
/// order.
struct SequenceCells {
  std::vector<ElementType> types;
  std::vector<std::size_t> offsets{0};    ///< size() + 1, into connectivity
  std::vector<Index> connectivity;        ///< vertex slots in VTK node order; a polytope's distinct vertices
  std::vector<std::int32_t> parts;        ///< PartId: the object of the element
  std::vector<std::int64_t> ids;          ///< GlobalCellIds: stable from step to step
  std::vector<std::size_t> face_offsets;  ///< size() + 1, into faces; empty if no cell is a polytope
  std::vector<Index> faces;               ///< polytopes: {n, v0 .. v(n-1), n, ...}, vertex slots

  std::size_t size() const { return types.size(); }
  std::span<const Index> vertices(std::size_t i) const {
    return {connectivity.data() + offsets[i], offsets[i + 1] - offsets[i]};
  }
  /// Empty unless cell i is a polytope.
  std::span<const Index> face_stream(std::size_t i) const {
    if (face_offsets.empty()) return {};
    return {faces.data() + face_offsets[i], face_offsets[i + 1] - face_offsets[i]};
  }

  ElementSpec spec(std::size_t i) const;
  void add(const ElementSpec& element);
  /// Empty, with the memory kept.
  void clear();

  friend bool operator==(const SequenceCells&, const SequenceCells&) = default;
};

/// The live elements of a mesh, by ascending slot.
SequenceCells cells_of(const Mesh& mesh);

/// A mesh of vertices with these ids (ascending) and these cells: element i gets slot i. Throws InputError as
/// Mesh::add_element does.
Mesh mesh_of(std::span<const std::int64_t> point_ids, const SequenceCells& cells);

/// What turns the elements of `mesh` into `cells`, told apart by their ids. An element whose type, vertices, faces or
/// part differ under the same id is removed and added. Added ones are in the order of `cells`. O(elements + cells)
/// expected.
TopologyEdit edit_to(const Mesh& mesh, const SequenceCells& cells);

}  // namespace volccd
