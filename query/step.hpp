// One query, as all stages see it.
#pragma once

#include <cstdint>
#include <span>

#include <volccd/mesh/topology.hpp>
#include <volccd/query/motion.hpp>
#include <volccd/query/object_filter.hpp>
#include <volccd/query/region.hpp>
#include <volccd/query/shell_neighbours.hpp>

namespace volccd {

/// Which element pairs are asked for.
enum class PairRange {
  nonadjacent,  ///< pairs of elements that are not adjacent (O-Sets cover the others, Section 5.1)
  every         ///< also pairs of adjacent elements, and the self pair (o, o) of each live element
};

/// What a topology is a part of, where several ranks divide a mesh (docs/distributed.md). By default it is the whole
/// mesh, and contacts are asked for in all of space. Stages may ignore all of it.
struct Piece {
  /// By vertex: not 0 only if the topology has all elements of the mesh at the vertex. Empty: it has all of them. A
  /// stage that leaves a step to others because of a share of the elements or vertices takes that share of complete
  /// vertices, and of elements all of whose vertices are complete.
  std::span<const std::uint8_t> complete = {};
  /// Not null: all elements of the mesh at the vertices that are not complete but have an element of the topology, so
  /// that their stars can be classified as in the mesh (docs/clear_stars.md). Vertices have the slots of the topology,
  /// which also has those of these elements. `complete` changes only with one of the two.
  const Topology* cut_stars = nullptr;
  /// Contacts whose features have their reference point outside need not be found: a stage may drop these tests. All of
  /// space where candidates are collected, which serve other motions.
  Region region = {};

  bool is_complete(Index v) const { return complete.empty() || complete[v] != 0; }
};

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
  /// The mesh is the solid mesh of a ShellThickener, and contacts of features that stem from the same vertex of the
  /// shell mesh (share_shell_vertex) are not asked for: sources may leave out their tests, and a pipeline drops
  /// what is left of these.
  bool leave_out_shell_neighbours = false;
  /// Which element pairs sources of work hand out. A pipeline sets it, whatever its caller has given.
  PairRange range = PairRange::every;
  Piece piece = {};
  /// Which elements are adjacent; null: those with a common vertex. Not null for a broad phase over parts of elements,
  /// whose owner sets it (a pipeline sets null, whatever its caller has given). It has the slots of the topology, is
  /// the same in all steps on it, and changes only with edits that remove or add the elements concerned.
  const Adjacency* adjacency_table = nullptr;

  const Adjacency& adjacency() const { return adjacency_table ? *adjacency_table : topology.adjacency(); }

  const Mesh& mesh() const { return topology.mesh(); }
  const Features& features() const { return topology.features(); }

  /// Whether contacts of a feature pair are asked for, by the object filter and as a shell neighbour.
  bool asks_for(FeatureKind kind, FeaturePair pair) const {
    return !(leave_out_shell_neighbours && share_shell_vertex(kind, test_vertices(features(), kind, pair))) &&
           filter.asks_for(topology, kind, pair);
  }
  /// Whether all of them are.
  bool asks_for_all() const { return filter.trivial() && !leave_out_shell_neighbours; }

  /// The same step with another t_max.
  Step until(double time) const {
    Step step = *this;
    step.t_max = time;
    return step;
  }
};

}  // namespace volccd
