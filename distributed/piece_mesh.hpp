// The part of a mesh that a rank holds, as a mesh of its own.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <volccd/distributed/elements.hpp>
#include <volccd/mesh/topology.hpp>
#include <volccd/query/step.hpp>

namespace volccd::distributed {

/// Elements that a rank received. `owners`, `complete`: one for each of elements.vertices.
struct ReceivedElements {
  Elements elements = {};
  std::vector<int> owners = {};             ///< the rank that gives the vertex
  std::vector<std::uint8_t> complete = {};  ///< not 0 if this rank receives all elements at the vertex
  std::uint64_t copies = 0;                 ///< elements whose centre is in the region of another rank
  std::uint64_t bytes = 0;                  ///< from other ranks
};

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

  /// Whether the piece serves for these elements: it was made with the same configuration, and contains them and at
  /// most a quarter more. Elements with the same id must be the same since the last clear(). Time O(elements log
  /// elements).
  bool serves(const Elements& elements, const Config& config) const;
  /// Makes this the piece of the given elements. `stars`: none, or all elements at the vertices that are not marked as
  /// complete; those that turn out to be complete are marked. Time O(elements log elements).
  void build(const ReceivedElements& received, const ReceivedElements& stars, const Config& config, Executor& executor);
  /// The piece serves for no elements.
  void clear() { *this = {}; }

  bool empty() const { return ids_.empty(); }
  /// Pre, here and below: not empty.
  const Topology& topology() const { return *topology_; }
  /// As a part of the mesh, all of space; valid as long as the piece.
  Piece piece() const { return {.complete = complete_, .cut_stars = cut_stars_ ? &*cut_stars_ : nullptr}; }
  /// Number of elements in Piece::cut_stars that the piece itself does not have; 0 for an empty piece.
  std::uint64_t halo() const { return halo_; }
  /// Ids of the vertices, ascending, and the owner of each: kNoRank for one that completes a group, if no element uses
  /// it.
  std::span<const std::int64_t> vertex_ids() const;
  std::span<const int> owners() const { return owners_; }

  static constexpr int kNoRank = -1;

 private:
  Config config_;
  std::vector<std::int64_t> ids_;       ///< of the elements, ascending
  std::vector<int> owners_;             ///< by vertex slot
  std::vector<std::uint8_t> complete_;  ///< by vertex slot
  std::optional<Topology> topology_, cut_stars_;
  std::uint64_t halo_ = 0;
};

}  // namespace volccd::distributed
