// Parts of a sequence by what hangs together, for files that store none.
#pragma once

#include <cstdint>
#include <vector>

#include <volccd/mesh/sequence/cells.hpp>
#include <volccd/mesh/sequence/reader.hpp>

namespace volccd {

/// The connected components of a sequence: two cells belong to one component if they share a vertex, at any step,
/// directly or through other cells. The cells of all steps decide together, so that an element keeps its component when
/// others come, go or split from it, and two bodies that are merged at some step are one component throughout.
class ConnectedParts {
 public:
  /// Reads the cells of all steps, a topology at a time. Throws what reading throws. Time almost linear in the cells of
  /// all stored topologies.
  explicit ConnectedParts(SequenceReader& reader);

  std::int32_t count() const { return count_; }

  /// Replaces the parts of cells of this sequence by their components: 0, 1, 2, ... by ascending smallest vertex.
  void assign(SequenceCells& cells) const;

 private:
  std::vector<std::int32_t> component_;  ///< of a vertex slot; -1: no cell uses it
  std::int32_t count_ = 0;
};

}  // namespace volccd
