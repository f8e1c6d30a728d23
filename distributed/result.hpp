// What a rank finds in a step.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/distributed/exchange.hpp>
#include <volccd/pipelines/statistics.hpp>
#include <volccd/query/contact.hpp>

namespace volccd::distributed {

/// A Contact whose vertices and elements are named by their ids.
struct RankContact {
  FeatureKind kind = FeatureKind::vf;
  std::array<std::int64_t, 4> vertices{};  ///< as Contact::vertices
  std::array<std::int64_t, 2> elements{};  ///< of each feature, the incident element of smallest id
  std::array<std::int32_t, 2> objects{};   ///< of these elements
  double toi = 0;
  Vec3 normal = Vec3::Zero();
  std::array<double, 4> weights{};
  Vec3 point = Vec3::Zero();
  bool at_start = false;
  double gap = 0;

  friend bool operator==(const RankContact&, const RankContact&) = default;
};

/// Canonical order: by kind, then by vertices.
inline bool canonical_less(const RankContact& x, const RankContact& y) {
  return x.kind != y.kind ? x.kind < y.kind : x.vertices < y.vertices;
}

/// Contacts as a message, and back.
Bytes to_bytes(std::span<const RankContact> contacts);
std::vector<RankContact> contacts_of(const Bytes& bytes);

/// What a rank did in a step, or in several.
struct RankStatistics {
  std::uint64_t elements = 0;        ///< elements that it held
  std::uint64_t copies = 0;          ///< those among them whose centre was in the region of another rank
  std::uint64_t halo = 0;            ///< elements around its piece, of which it classifies stars alone
  std::uint64_t tests = 0;           ///< elementary tests that it performed
  std::uint64_t contacts = 0;        ///< contacts that it found, all of which are its own
  double seconds = 0;                ///< wall-clock time of its pipeline
  double piece_seconds = 0;          ///< wall-clock time for boxes, lists of elements and its piece, without messages
  std::uint64_t lists = 0;           ///< in how many steps ranks made new lists of elements
  std::uint64_t bytes_received = 0;  ///< positions and elements from other ranks
  std::uint64_t neighbours = 0;  ///< ranks from which it received positions for its piece; of several steps the maximum

  RankStatistics& operator+=(const RankStatistics& other);
};

/// The contacts that one rank keeps. Each contact of the mesh is kept by one rank.
struct RankResult {
  std::vector<RankContact> contacts;  ///< in canonical order
  /// If requested: pairs of element ids, the smaller one first, ascending.
  std::vector<std::array<std::int64_t, 2>> initial_overlaps;
  Statistics statistics;  ///< of this rank's pipeline
  RankStatistics rank;
};

}  // namespace volccd::distributed
