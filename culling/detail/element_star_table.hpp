// The connectivity of elements of any type around vertices, for StarOrphans.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/culling/detail/boundary_rings.hpp>
#include <volccd/culling/detail/star_table.hpp>
#include <volccd/mesh/topology_delta.hpp>

namespace volccd::detail {

/// The star of a vertex consists of all elements at the vertex. Its kind: `interior` if each of their faces at the
/// vertex has exactly two elements, which have the same vertices in it in opposite order; `ring` if the other faces at
/// the vertex have one element each, and their sides that do not contain the vertex form one closed ring; `irregular`
/// for anything else, and if an element of the star is a shell or a polytope.
class ElementStarTable final : public StarKinds {
 public:
  /// Updates the table for the topology. The time is proportional to the size of the change. Returns the extent of the
  /// change.
  TopologyDelta::Extent update(const Topology& topology, Executor& executor);
  /// The boundary faces that have a vertex with a ring. A quad becomes four triangles, so that each vertex is tested
  /// with the two triangles of the mesh and with the two that have it in common.
  std::vector<RingFace> boundary_faces(const Topology& topology) const;

  std::size_t bytes() const { return kinds_bytes() + heap_bytes(faces_, scratch_); }

 private:
  enum class Face : std::uint8_t { none, inner, boundary, irregular };

  void set_faces(const Topology& topology, Index o);
  bool find_open(const Topology& topology, Index v, std::vector<std::array<Index, 2>>& open) const override;

  std::vector<std::array<Face, 6>> faces_;  ///< by element slot, in the order of face_stream()
  std::vector<Ring> scratch_;
};

/// Calls visit(face, number) for each face of an element with a face stream; `face` contains vertex slots in cyclic
/// order, outward for an element of positive volume.
template <class Visit>
void visit_faces(const Mesh& mesh, Index o, Visit&& visit) {
  const std::span<const Index> v = mesh.vertices(o);
  std::array<Index, 4> face;
  std::size_t number = 0;
  volccd::visit_faces(face_stream(mesh.type(o)), [&](std::span<const std::uint8_t> numbers) {
    for (std::size_t j = 0; j < numbers.size(); ++j) face[j] = v[numbers[j]];
    visit(std::span<const Index>(face.data(), numbers.size()), number++);
  });
}

}  // namespace volccd::detail
