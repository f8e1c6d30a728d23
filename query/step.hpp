// One query, as every stage sees it.
#pragma once

#include <volccd/mesh/topology.hpp>
#include <volccd/query/element_subset.hpp>
#include <volccd/query/motion.hpp>
#include <volccd/query/object_filter.hpp>

namespace volccd {

/// Motion of one step on one topology, and what the caller asks for. A value of references: cheap to copy; what it
/// refers to outlives the call and does not change during it.
struct Step {
  const Topology& topology;
  const Motion& motion;       ///< motion.vertex_count() == topology.mesh().vertex_count()
  const ObjectFilter& filter;
  /// Contact when the distance reaches this, in the unit of the coordinates (finite, >= 0). 0: when they touch.
  double separation = 0;
  /// Contacts later than this need not be found: a stage may drop what touches only after t_max. 1: all of the step. A
  /// stage may ignore it.
  double t_max = 1;
  /// The elements that a broad phase pairs; null: all live ones.
  const ElementSubset* subset = nullptr;

  const Mesh& mesh() const { return topology.mesh(); }
  const Features& features() const { return topology.features(); }
  bool takes_part(Index o) const { return mesh().is_live(o) && (!subset || subset->contains(o)); }
};

}  // namespace volccd
