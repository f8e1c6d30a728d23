// Mesh, Features and Adjacency that change together: the only way to edit a mesh whose features are in use.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <volccd/mesh/adjacency.hpp>
#include <volccd/mesh/features.hpp>
#include <volccd/mesh/mesh.hpp>

namespace volccd {

/// Elements and vertices that come and go between two steps (Section 5.1: O' = O + A_s - A_t).
struct TopologyEdit {
  std::vector<Index> removed;                ///< slots of live elements, each once
  std::vector<std::int64_t> new_vertex_ids;  ///< ascending, above all that are there; usable by `added`
  std::vector<ElementSpec> added;

  bool empty() const { return removed.empty() && added.empty() && new_vertex_ids.empty(); }
};

/// What an edit did. `version` is the topology's version after it.
struct TopologyChange {
  std::uint64_t version = 0;
  std::vector<Index> removed_elements, added_elements;  ///< ascending slots; one slot may be in both
  FeatureChange features;
};

/// Owns a Mesh, its Features and its Adjacency: all tables that depend on the elements alone, so that no stage needs a
/// copy. Every edit raises the version; the state of a stage remembers the version that it was updated for, and asks for
/// what has changed since (TopologyDelta).
class Topology {
 public:
  explicit Topology(Mesh mesh, EdgeSet edge_set = EdgeSet::triangulated);

  const Mesh& mesh() const { return mesh_; }
  const Features& features() const { return features_; }
  const Adjacency& adjacency() const { return adjacency_; }

  /// Distinct in every Topology object and after every edit (never 0), so that a state which was made for another
  /// topology is noticed.
  std::uint64_t version() const { return version_; }

  /// All or nothing: throws InputError, or std::bad_alloc if memory runs out, before anything is changed. Time
  /// proportional to the edit, not to the mesh.
  const TopologyChange& apply(const TopologyEdit& edit);

  /// The changes that lead from `version` to now, oldest first (none if it is the current one). Returns false, with
  /// `changes` empty, if the history does not reach back that far (another topology, or more than kHistory edits ago):
  /// the caller builds anew.
  bool changes_since(std::uint64_t version, std::vector<const TopologyChange*>& changes) const;

  static constexpr std::size_t kHistory = 8;

  /// True if some vertex belongs to elements of different objects.
  bool objects_share_vertices() const { return shared_vertices_ != 0; }

  std::size_t bytes() const;

 private:
  void check(const TopologyEdit& edit) const;
  void check_removed(const TopologyEdit& edit) const;
  void check_new_vertices(const TopologyEdit& edit) const;
  void check_added(const TopologyEdit& edit) const;
  void note_object(std::int32_t object);
  bool makes_several(std::span<const ElementSpec> added) const;
  bool is_shared(Index vertex) const;
  Index count_shared(std::span<const Index> vertices) const;

  Mesh mesh_;
  Features features_;
  Adjacency adjacency_;
  std::uint64_t version_;
  std::uint64_t base_version_;  ///< version before the oldest change kept
  std::vector<std::unique_ptr<TopologyChange>> history_;
  std::optional<std::int32_t> first_object_;
  bool several_objects_ = false;  ///< as long as there never were, no vertex is shared and nothing need be counted
  Index shared_vertices_ = 0;
};

}  // namespace volccd
