#include <volccd/io/sequence/detail/frame_check.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/mesh/check_element.hpp>

namespace volccd::detail {

namespace {

void check_length(const std::string& file, const std::string& dataset, std::size_t length, std::size_t wanted) {
  if (length != wanted)
    throw InputError(file, dataset, fmt::format("has {} entries, but must have {}", length, wanted));
}

/// Checks CSR offsets: one more than there are cells, non-descending, from 0 to `length`.
void check_offsets(const std::string& file, const std::string& dataset, const std::vector<std::size_t>& offsets,
                   std::size_t cells, std::size_t length) {
  check_length(file, dataset, offsets.size(), cells + 1);
  if (offsets.front() != 0 || offsets.back() != length || !std::is_sorted(offsets.begin(), offsets.end()))
    throw InputError(file, dataset, "do not ascend from 0 to the length of the array to which they refer");
}

}  // namespace

std::optional<WrongId> find_wrong_id(std::span<const std::int64_t> ids) {
  for (std::size_t i = 0; i < ids.size(); ++i)
    if (ids[i] < 0) return WrongId{i, fmt::format("the id is negative: {}", ids[i])};
  const std::size_t i = find_repeated(ids);
  if (i == ids.size()) return std::nullopt;
  return WrongId{i, fmt::format("the id {} is there twice", ids[i])};
}

void check_ids(const std::string& file, const std::string& dataset, std::span<const std::int64_t> ids) {
  if (const std::optional<WrongId> wrong = find_wrong_id(ids))
    throw InputError(file, dataset, static_cast<std::int64_t>(wrong->index), wrong->problem);
}

void check_vectors(const std::string& dataset, std::span<const Vec3> vectors, const FramePlace& place) {
  check_length(place.file, dataset, vectors.size(), place.point_ids.size());
  for (std::size_t i = 0; i < vectors.size(); ++i)
    if (!vectors[i].allFinite())
      throw InputError(place.file, dataset, static_cast<std::int64_t>(i),
                       fmt::format("is not finite (point id {}, frame {})", place.point_ids[i], place.frame));
}

void check_thickness(const std::string& dataset, std::span<const double> values, const SequenceCells& cells,
                     const FramePlace& place) {
  check_length(place.file, dataset, values.size(), cells.size());
  check_length(place.file, "VTKHDF/CellData/GlobalCellIds", cells.ids.size(), cells.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!(std::isfinite(values[i]) && values[i] >= 0))
      throw InputError(place.file, dataset, static_cast<std::int64_t>(i),
                       fmt::format("is negative or not finite (cell id {}, frame {})", cells.ids[i], place.frame));
}

void check_cells(const SequenceCells& cells, const FramePlace& place) {
  if (cells.size() == 0) throw InputError(place.file, "VTKHDF/Types", "no cells");
  check_offsets(place.file, "VTKHDF/Offsets", cells.offsets, cells.size(), cells.connectivity.size());
  if (!cells.face_offsets.empty())
    check_offsets(place.file, "VTKHDF/FaceOffsets", cells.face_offsets, cells.size(), cells.faces.size());
  check_length(place.file, "VTKHDF/CellData/PartId", cells.objects.size(), cells.size());
  check_length(place.file, "VTKHDF/CellData/GlobalCellIds", cells.ids.size(), cells.size());
  check_ids(place.file, "VTKHDF/CellData/GlobalCellIds", cells.ids);
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (const std::string problem =
            element_problem(cells.spec(i), static_cast<Index>(place.point_ids.size()), place.point_ids);
        !problem.empty())
      throw InputError(place.file, "VTKHDF/Connectivity", static_cast<std::int64_t>(i),
                       fmt::format("{} (cell id {}, frame {})", problem, cells.ids[i], place.frame));
}

}  // namespace volccd::detail
