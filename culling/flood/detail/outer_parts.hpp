// The outer parts of the simplices of a complex: what a flood pairs first.
#pragma once

#include <cstdint>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/core/heap_bytes.hpp>
#include <volccd/culling/flood/detail/part_table.hpp>
#include <volccd/culling/stars/vertex_stars.hpp>
#include <volccd/query/step.hpp>

namespace volccd::detail {

/// The outer part of a simplex is the whole simplex if it is a triangle, has a *marked* vertex, or has several boundary
/// faces; otherwise its boundary face, if it has one. A simplex that is not outer as a whole has an inside. All
/// vertices with suspect stars are marked. Those of earlier steps remain marked until they are many, so that few parts
/// change from step to step. The union of the outer parts is the set S of docs/boundary_flood.md. Not thread-safe.
class OuterParts {
 public:
  /// Updates the parts for the step of the last stars.update(). O(marked vertices + elements at vertices that became
  /// marked or unmarked, or whose elements changed), and O(elements) after edits of the topology, for the connected
  /// components. Does not allocate where no vertex becomes marked.
  void update(const Step& step, const VertexStars& stars, Executor& executor);

  const PartTable& table() const { return table_; }
  /// At least one vertex of each connected component of S, ascending.
  const std::vector<Index>& chosen_vertices() const { return chosen_; }

  std::size_t bytes() const {
    return heap_bytes(delta_, table_, boundary_kinds_, components_, parents_, marked_, is_marked_, vertices_, chosen_,
                      slots_);
  }

 private:
  void mark_vertices(const Step& step, const VertexStars& stars, bool edited);
  void find_changed_slots(const Step& step);
  void find_components(const Step& step);
  void choose_vertices(const Step& step);

  TopologyDelta delta_;
  PartTable table_;
  std::vector<PartTable::Kind> boundary_kinds_;  ///< by slot: the part if no vertex is marked
  std::vector<Index> components_;                ///< a vertex of each connected component of the boundary parts
  std::vector<Index> parents_;                   ///< by vertex: kNone if it is of no boundary part
  std::vector<Index> marked_;                    ///< ascending
  std::vector<std::uint8_t> is_marked_;          ///< by vertex
  std::vector<Index> vertices_;                  ///< those that became marked or unmarked; scratch memory of update()
  std::vector<Index> chosen_;
  std::vector<Index> slots_;  ///< scratch memory of update()
};

}  // namespace volccd::detail
