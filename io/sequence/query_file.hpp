// Reading a query file: single elementary tests with known results.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <volccd/query/pairs.hpp>

namespace volccd {

/// The queries of one scene and kind, in file order.
struct QueryGroup {
  std::string scene;
  FeatureKind kind = FeatureKind::vf;
  /// Eight points per query: four at t = 0, then the same four at t = 1. VF: vertex, triangle; EE: edge 1, edge 2. This
  /// is the input format of QuerySet.
  std::vector<Vec3> points;
  std::vector<std::uint8_t> collides;   ///< 0 or 1: whether the features touch for some t in [0, 1]
  std::vector<std::string> file_names;  ///< names of the files from which the queries were taken
  std::vector<std::uint32_t> file;      ///< index into file_names, one per query

  std::size_t size() const { return collides.size(); }
};

/// All queries of an HDF5 file with groups /SCENE/VertexFace and /SCENE/EdgeEdge, each optional. Each group contains
/// Points [q, 8, 3] of real numbers, Collides [q] with values 0 or 1, and File [q] with indices into the attribute
/// Files, a list of names separated by blanks. Results are in the order of scene names, VF before EE; groups without
/// queries are omitted.
///
/// Throws InputError with file, dataset and index of the query if there are no scenes, an object at the root is not a
/// scene, a dataset or attribute is missing or has another type or shape, arrays differ in length, a coordinate is not
/// finite, Collides is not 0 or 1, or File is out of range.
std::vector<QueryGroup> read_query_file(const std::string& file);

/// Whether the file has the group of a sequence (SequenceReader); then it is not a query file. Throws InputError if the
/// file does not exist or is not an HDF5 file.
bool is_sequence_file(const std::string& file);

}  // namespace volccd
