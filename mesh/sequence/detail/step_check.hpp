// Checks of what is handed to a writer.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include <volccd/mesh/sequence/cells.hpp>
#include <volccd/mesh/types.hpp>

namespace volccd::detail {

/// All throw InputError with `file`, the dataset, and the index of what is wrong.

/// Distinct, none negative.
void check_ids(const std::string& file, const std::string& dataset, std::span<const std::int64_t> ids);
/// `count` of them, finite.
void check_vectors(const std::string& file, const std::string& dataset, std::span<const Vec3> vectors,
                   std::size_t count);
/// `count` of them, finite and not negative.
void check_thickness(const std::string& file, const std::string& dataset, std::span<const double> values,
                     std::size_t count);
/// Arrays of fitting lengths, and cells that a Mesh of `points` vertices takes. The index is the cell's.
void check_cells(const std::string& file, const SequenceCells& cells, Index points);

}  // namespace volccd::detail
