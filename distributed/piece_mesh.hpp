// The part of a mesh that a rank holds, as a mesh of its own.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <volccd/distributed/elements.hpp>
#include <volccd/mesh/topology.hpp>

namespace volccd::distributed {

/// Some elements of a mesh with all their vertices. Vertices and elements have their ids, and vertex slots ascend with
/// the ids, as in the whole mesh, so that features, the order of vertices in a test, and contacts are those of the
/// whole.
class PieceMesh {
 public:
  /// What the vertices of the mesh are, besides corners of elements.
  struct Config {
    /// Vertices come in groups: those whose ids, divided by this and rounded down, are the same. The piece holds all or
    /// none of a group (3 for the solid meshes of thickened shells, otherwise 1).
    std::int64_t vertex_group = 1;
    EdgeSet edge_set = EdgeSet::triangulated;

    friend bool operator==(const Config&, const Config&) = default;
  };

  /// Makes this the piece of the given elements, with the owning rank of each of elements.vertices. Returns false if
  /// the present piece remains: if it was made with the same configuration, and contains the elements and at most a
  /// quarter more. Elements with the same id must be the same since the last clear(). Expected time O(elements).
  bool update(const Elements& elements, std::span<const int> owners, const Config& config, Executor& executor);
  /// The next update makes a new piece.
  void clear() { topology_.reset(), ids_.clear(), owners_.clear(); }

  bool empty() const { return ids_.empty(); }
  /// Pre, here and below: not empty.
  const Topology& topology() const { return *topology_; }
  /// Ids of the vertices, ascending, and the owner of each: kNoRank for one that completes a group, if no element of
  /// the piece uses it.
  std::span<const std::int64_t> vertex_ids() const;
  std::span<const int> owners() const { return owners_; }

  static constexpr int kNoRank = -1;

 private:
  void build(const Elements& elements, std::span<const int> owners, Executor& executor);

  Config config_;
  std::vector<std::int64_t> ids_;  ///< of the elements, ascending
  std::vector<int> owners_;        ///< by vertex slot
  std::optional<Topology> topology_;
};

}  // namespace volccd::distributed
