// Reading a query file: single elementary tests with known answers.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <volccd/query/pairs.hpp>

namespace volccd {

/// The queries of one scene and kind, in the order of the file.
struct QueryGroup {
  std::string scene;
  FeatureKind kind = FeatureKind::vf;
  /// Eight a query: four at t = 0, the same at t = 1. VF: vertex, triangle; EE: edge 1, edge 2. What QuerySet takes.
  std::vector<Vec3> points;
  std::vector<std::uint8_t> collides;   ///< 0 or 1: whether they touch for some t in [0, 1]
  std::vector<std::string> file_names;  ///< where the queries are from
  std::vector<std::uint32_t> file;      ///< index into file_names, one a query

  std::size_t size() const { return collides.size(); }
};

/// All queries of an HDF5 file with groups /SCENE/VertexFace and /SCENE/EdgeEdge, either of which may be absent:
/// Points [q, 8, 3] of reals, Collides [q] 0 or 1, File [q] index into the names in the attribute Files, which blanks
/// separate. Scenes by name, VF before EE; groups without queries are left out.
///
/// Throws InputError with file, dataset and index of the query: no scenes, something at the root that is none, a
/// dataset or attribute that is missing or of another type or shape, arrays of different lengths, a coordinate that is
/// not finite, Collides not 0 or 1, File out of range.
std::vector<QueryGroup> read_query_file(const std::string& file);

/// Whether the file has the group of a sequence (SequenceReader): then it is no query file. Throws InputError if it is
/// not there or no HDF5 file.
bool is_sequence_file(const std::string& file);

}  // namespace volccd
