// A Mesh with its Features and Adjacency, which change together. This is the only way to edit a mesh whose features are
// in use.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <volccd/mesh/adjacency.hpp>
#include <volccd/mesh/features.hpp>
#include <volccd/mesh/mesh.hpp>

namespace volccd {

/// Elements to remove, then vertices and elements to add, between two steps (Section 5.1: O' = O + A_s - A_t).
struct TopologyEdit {
  std::vector<Index> removed = {};                ///< slots of live elements, each once
  std::vector<std::int64_t> new_vertex_ids = {};  ///< ascending, greater than all present ids; `added` may use them
  std::vector<ElementSpec> added = {};

  bool empty() const { return removed.empty() && added.empty() && new_vertex_ids.empty(); }
};

/// The result of an edit. `version` is the version of the topology after the edit.
struct TopologyChange {
  std::uint64_t version = 0;
  std::vector<Index> removed_elements, added_elements;  ///< slots, ascending; a slot may be in both lists
  FeatureChange features;
};

/// Owns a Mesh, its Features and its Adjacency, all tables that depend on the elements alone, so that no stage needs
/// its own copy. Every edit increases the version. The state of a stage stores the version for which it was last
/// updated, and determines the changes since then with a TopologyDelta.
class Topology {
 public:
  explicit Topology(Mesh mesh, EdgeSet edge_set = EdgeSet::triangulated)
      : Topology(std::move(mesh), serial_executor(), edge_set) {}
  /// The same topology, built by all workers of the executor, which is not stored. Expected time O(elements).
  Topology(Mesh mesh, Executor& executor, EdgeSet edge_set = EdgeSet::triangulated);

  const Mesh& mesh() const { return mesh_; }
  const Features& features() const { return features_; }
  const Adjacency& adjacency() const { return adjacency_; }

  /// Never 0, and different for every Topology object and after every edit. A state can therefore detect that it
  /// belongs to another topology.
  std::uint64_t version() const { return version_; }

  /// Applies an edit. Throws InputError if the mesh does not allow the edit, and std::bad_alloc; in both cases the
  /// topology is unchanged. The amortised time is proportional to the size of the edit, not of the mesh.
  const TopologyChange& apply(const TopologyEdit& edit);

  /// Replaces `changes` by the changes since `version`, oldest first. Returns false, with `changes` empty, if the
  /// history does not contain that version (it belongs to another topology, or is more than kHistory edits old).
  bool changes_since(std::uint64_t version, std::vector<const TopologyChange*>& changes) const;

  static constexpr std::size_t kHistory = 8;

  /// True if the vertex belongs to elements of different objects, and if some vertex does.
  bool is_shared(Index vertex) const;
  bool objects_share_vertices() const { return shared_vertices_ != 0; }

  std::size_t bytes() const;

 private:
  void note_object(std::int32_t object);
  Index count_shared(std::span<const Index> vertices) const;
  Index count_all_shared(Executor& executor) const;

  Mesh mesh_;
  Features features_;
  Adjacency adjacency_;
  std::uint64_t version_;
  std::uint64_t base_version_;  ///< version before the oldest change in history_
  std::vector<std::unique_ptr<TopologyChange>> history_;
  std::optional<std::int32_t> first_object_;
  bool several_objects_ = false;  ///< if false, all elements have had the same object, and no vertex can be shared
  Index shared_vertices_ = 0;
};

}  // namespace volccd
