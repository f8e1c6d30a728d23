// Connected components of a sequence, as a replacement for objects in files that store none.
#pragma once

#include <cstdint>
#include <vector>

#include <volccd/io/sequence/cells.hpp>
#include <volccd/io/sequence/reader.hpp>

namespace volccd {

/// The connected components of a sequence: two cells belong to one component if they share a vertex at any frame,
/// directly or through other cells. The cells of all frames are taken together. Therefore an element keeps its
/// component when other elements are added, removed or split from it, and two bodies that are merged at some frame are
/// one component in all frames.
class ConnectedComponents {
 public:
  /// Reads the cells of all frames, one topology at a time, and throws the errors of reading. The time is almost linear
  /// in the number of cells of all stored topologies.
  explicit ConnectedComponents(SequenceReader& reader);

  std::int32_t count() const { return count_; }

  /// Replaces the objects of cells of this sequence by component numbers 0, 1, 2, ..., in ascending order of the
  /// smallest vertex of the components.
  void assign(SequenceCells& cells) const;

 private:
  std::vector<std::int32_t> component_;  ///< component of each vertex slot; -1 if no cell uses the vertex
  std::int32_t count_ = 0;
};

}  // namespace volccd
