// Checks of ids, and of the data that are given to a writer.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include <volccd/io/sequence/cells.hpp>
#include <volccd/numerics/types.hpp>

namespace volccd::detail {

/// The first negative id or, if there is none, the second occurrence of the smallest repeated id.
struct WrongId {
  std::size_t index;
  std::string problem;
};
std::optional<WrongId> find_wrong_id(std::span<const std::int64_t> ids);

/// All functions below throw InputError with the file, the dataset, and the index of the invalid entry.

/// Checks that the ids are distinct and not negative.
void check_ids(const std::string& file, const std::string& dataset, std::span<const std::int64_t> ids);
/// The frame of a file and the ids of its points, for messages.
struct FramePlace {
  const std::string& file;
  std::int64_t frame;
  std::span<const std::int64_t> point_ids;
};

/// Checks that there is one vector per point, and that all are finite.
void check_vectors(const std::string& dataset, std::span<const Vec3> vectors, const FramePlace& place);
/// Checks that there is one value per cell, and that all are finite and not negative.
void check_thickness(const std::string& dataset, std::span<const double> values, const SequenceCells& cells,
                     const FramePlace& place);
/// Checks that the arrays have consistent lengths, and that a Mesh with these points accepts the cells. The index is
/// that of the cell.
void check_cells(const SequenceCells& cells, const FramePlace& place);

}  // namespace volccd::detail
