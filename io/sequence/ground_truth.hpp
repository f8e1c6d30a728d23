// Known results of tests in a motion, from the group GroundTruth of a sequence file.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include <volccd/io/sequence/reader.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd {

/// The known result for a pair of features. The vertex ids are in the order of a Contact: VF {vertex, triangle
/// ascending}; EE {edge ascending, edge ascending}, the smaller edge first.
struct KnownAnswer {
  FeatureKind kind;
  std::array<std::int64_t, 4> ids;
  bool collides;
  /// The earliest time of contact in [0, 1]; NaN if there is no contact, or if the file has no times.
  double toi = std::numeric_limits<double>::quiet_NaN();
};

/// The known results for the motion 0 -> 1 of the file, VF pairs first, each kind in file order. Empty if the file has
/// no group GroundTruth. The group consists of Edges [m, 2], point indices, and the groups VertexFace and EdgeEdge,
/// each optional, with Pairs [p, 2] (VF: point index and cell of frame 0; EE: two rows of Edges), Collides [p] and,
/// optionally, TimeOfImpact [p]. Indices refer to the order in the file, before vertices are sorted by id.
///
/// Throws InputError with dataset and row if an index is out of range, a cell is not a triangle, two features have a
/// common vertex, Collides is not 0 or 1, a time is outside [0, 1], or a time is given without a contact or missing for
/// a contact.
std::optional<std::vector<KnownAnswer>> read_ground_truth(SequenceReader& reader);

}  // namespace volccd
