// Known answers for a motion, from the group GroundTruth of a sequence file.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <volccd/mesh/sequence/reader.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd {

/// A pair of features, by vertex ids, in the order of a Contact: VF {vertex, triangle ascending}; EE {edge ascending,
/// edge ascending}, the smaller edge first.
struct KnownAnswer {
  FeatureKind kind;
  std::array<std::int64_t, 4> ids;
  bool collides;
  /// The earliest time of contact in [0, 1]; NaN where there is none, or where the file has no times.
  double toi = std::numeric_limits<double>::quiet_NaN();
};

/// The answers for the motion 0 -> 1 of the file, VF first, each kind in the order of the file; nothing if it has no
/// group GroundTruth. The group is laid out so: Edges [m, 2] point indices; VertexFace and EdgeEdge, either of which
/// may be absent, with Pairs [p, 2] (point index and cell of step 0; two rows of Edges), Collides [p] and, optionally,
/// TimeOfImpact [p]. Indices are those of the file, before vertices are put in the order of their ids.
///
/// Throws InputError with dataset and row: index out of range, a cell that is no triangle, two features with a common
/// vertex, Collides not 0 or 1, a time outside [0, 1], a time where nothing collides or none where something does.
std::optional<std::vector<KnownAnswer>> read_ground_truth(SequenceReader& reader);

}  // namespace volccd
