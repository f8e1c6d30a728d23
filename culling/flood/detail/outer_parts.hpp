// The outer parts of the simplices of a complex: what the broad phase of a flood pairs.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/culling/stars/vertex_stars.hpp>
#include <volccd/query/element_subset.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// The outer part of a simplex is the whole simplex if it is a triangle, has a vertex with a suspect star, or has
/// several boundary faces; otherwise its boundary face, if it has one. A simplex that is not outer as a whole has an
/// inside. The union of the outer parts is the set S of docs/boundary_flood.md. Not thread-safe.
class OuterParts {
 public:
  /// Updates the parts for the step of the last stars.update(). O(elements at vertices that became suspect or clear, or
  /// whose elements changed), and O(elements) after edits of the topology for the connected components.
  void update(const Step& step, const VertexStars& stars);

  const ElementSubset& subset() const { return subset_; }
  /// At least one vertex of each connected component of S, ascending.
  const std::vector<Index>& chosen_vertices() const { return chosen_; }

  std::size_t bytes() const {
    return heap_bytes(delta_, subset_, boundary_parts_, components_, parents_, suspects_, chosen_, slots_);
  }

 private:
  void find_changed_slots(const Step& step, const VertexStars& stars);
  void find_components(const Step& step);
  std::uint8_t part_of(const Mesh& mesh, const VertexStars& stars, Index o) const;
  void choose_vertices(const Step& step, const VertexStars& stars);

  TopologyDelta delta_;
  ElementSubset subset_;
  std::vector<std::uint8_t> boundary_parts_;  ///< by slot: the part if no star but irregular ones is suspect
  std::vector<Index> components_;             ///< a vertex of each connected component of the boundary parts
  std::vector<Index> parents_;                ///< by vertex: scratch memory of find_components()
  std::vector<Index> suspects_;               ///< of the last update
  std::vector<Index> chosen_;
  std::vector<Index> slots_;  ///< scratch memory of update()
};

}  // namespace volccd::detail
