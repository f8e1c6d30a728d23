// One query, as all stages see it.
#pragma once

#include <volccd/mesh/topology.hpp>
#include <volccd/query/element_subset.hpp>
#include <volccd/query/motion.hpp>
#include <volccd/query/object_filter.hpp>

namespace volccd {

/// The motion of one step on one topology, and the options of the query. Contains references and is cheap to copy; the
/// referenced objects must outlive the call and must not change during it.
struct Step {
  const Topology& topology;
  const Motion& motion;  ///< motion.vertex_count() == topology.mesh().vertex_count()
  const ObjectFilter& filter;
  /// Distance, in the unit of the coordinates, at which features are in contact (finite, >= 0). For 0 they are in
  /// contact when they touch.
  double separation = 0;
  /// Contacts later than t_max need not be found: a stage may drop pairs that touch only after t_max, or may ignore
  /// this value. 1: the whole step.
  double t_max = 1;
  /// The elements that the broad phase pairs, and the parts of them that have to overlap; null: all live elements. Only
  /// a broad phase receives a step with a subset.
  const ElementSubset* subset = nullptr;

  const Mesh& mesh() const { return topology.mesh(); }
  const Features& features() const { return topology.features(); }
  bool takes_part(Index o) const { return mesh().is_live(o) && (!subset || subset->contains(o)); }
  /// The vertices of the part of o that takes part: all vertices of the element, or those of a smaller part, of which
  /// one may be repeated. Pre: takes_part(o).
  std::span<const Index> part(Index o) const {
    return subset && !subset->contains_whole(o) ? subset->part(o) : mesh().vertices(o);
  }
};

}  // namespace volccd
