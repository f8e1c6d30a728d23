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
/// What messages name a step and its points by.
struct StepPlace {
  std::int64_t step;
  std::span<const std::int64_t> point_ids;
};

/// As many as points, finite.
void check_vectors(const std::string& file, const std::string& dataset, std::span<const Vec3> vectors,
                   const StepPlace& place);
/// As many as cells, finite and not negative.
void check_thickness(const std::string& file, const std::string& dataset, std::span<const double> values,
                     const SequenceCells& cells, const StepPlace& place);
/// Arrays of fitting lengths, and cells that a Mesh of these points takes. The index is the cell's.
void check_cells(const std::string& file, const SequenceCells& cells, const StepPlace& place);

}  // namespace volccd::detail
