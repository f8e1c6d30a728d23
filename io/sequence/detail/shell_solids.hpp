// The cells of a frame with thickened shells, and the positions of their vertices.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <volccd/io/sequence/cells.hpp>
#include <volccd/io/sequence/reader.hpp>
#include <volccd/mesh/shells.hpp>

namespace volccd::detail {

class ShellSolids {
 public:
  /// Throws InputError if the point ids are too large to be multiplied by three.
  explicit ShellSolids(SequenceReader& reader);

  /// Ids of the vertices of the solid mesh, three for each point.
  const std::vector<std::int64_t>& vertex_ids() const { return vertex_ids_; }

  /// Sets the cells to be thickened.
  void set_cells(const SequenceCells& cells);
  /// The solids, in the order of the cells.
  const SequenceCells& cells() const { return solids_; }

  /// Computes the positions of the solid mesh at both ends of a motion. Each end uses the thickness of its frame,
  /// `start` or `end`; the cells are those of `end`, and a shell that does not exist at `start` has its thickness of
  /// `end`. Returns the number of vertices without a mean normal, summed over both ends. Throws InputError if there are
  /// shells but the file has no thickness.
  Index positions(int start, int end, std::span<const Vec3> x0, std::span<const Vec3> x1, std::vector<Vec3>& solid0,
                  std::vector<Vec3>& solid1);

 private:
  void read_thickness(int start, int end);

  SequenceReader& reader_;
  std::vector<std::int64_t> vertex_ids_;
  Mesh mesh_;  ///< element i is cell i
  std::optional<ShellThickener> thickener_;
  ShellThickener::Scratch scratch_;
  SequenceCells solids_, before_;
  std::vector<double> thickness0_, thickness1_, thickness_before_;
};

}  // namespace volccd::detail
