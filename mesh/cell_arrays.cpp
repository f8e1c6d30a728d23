#include <volccd/mesh/cell_arrays.hpp>

#include <algorithm>

#include <fmt/format.h>

#include <volccd/core/error.hpp>

namespace volccd {

namespace {

[[noreturn]] void refuse_cell(const char* array, std::size_t index, const std::string& problem) {
  throw InputError("cells", array, static_cast<std::int64_t>(index), problem);
}

void check_types(std::span<const std::uint8_t> types) {
  for (std::size_t i = 0; i < types.size(); ++i)
    if (!is_element_type(types[i]))
      refuse_cell("types", i,
                  fmt::format("VTK cell type {} is none that a mesh can hold: triangle 5, quad 9, tetrahedron 10, "
                              "hexahedron 12, wedge 13, pyramid 14, polyhedron 42",
                              types[i]));
}

void check_offsets(std::span<const std::int64_t> offsets, std::size_t cells, std::size_t length, const char* array) {
  if (offsets.size() != cells + 1)
    throw InputError("cells", array, fmt::format("{} cells need {} offsets, not {}", cells, cells + 1, offsets.size()));
  for (std::size_t i = 0; i < offsets.size(); ++i)
    if (offsets[i] < (i == 0 ? 0 : offsets[i - 1]) || static_cast<std::size_t>(offsets[i]) > length)
      refuse_cell(array, i, fmt::format("{}: offsets must ascend from 0 to {}", offsets[i], length));
  if (offsets.front() != 0 || static_cast<std::size_t>(offsets.back()) != length)
    throw InputError("cells", array, fmt::format("offsets must begin with 0 and end with {}", length));
}

/// Whether all values fit an Index. A face stream also contains counts.
void check_indices(std::span<const std::int64_t> values, const char* array) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (values[i] < 0 || values[i] >= static_cast<std::int64_t>(kNone))
      refuse_cell(array, i, fmt::format("{} is not the number of a vertex", values[i]));
}

void check_length(std::size_t length, std::size_t cells, const char* array) {
  if (length != 0 && length != cells)
    throw InputError("cells", array, fmt::format("{} cells need {} values, not {}", cells, cells, length));
}

/// Row i of an array in CSR form; empty if there are no offsets.
std::vector<Index> row(std::span<const std::int64_t> offsets, std::span<const std::int64_t> values, std::size_t i) {
  if (offsets.empty()) return {};
  const auto begin = static_cast<std::size_t>(offsets[i]), end = static_cast<std::size_t>(offsets[i + 1]);
  std::vector<Index> result(end - begin);
  std::ranges::transform(values.subspan(begin, end - begin), result.begin(),
                         [](std::int64_t value) { return static_cast<Index>(value); });
  return result;
}

ElementSpec element(const CellArrays& cells, std::size_t i) {
  return {.type = static_cast<ElementType>(cells.types[i]),
          .vertices = row(cells.offsets, cells.connectivity, i),
          .faces = row(cells.face_offsets, cells.faces, i),
          .object = cells.objects.empty() ? 0 : cells.objects[i],
          .id = cells.ids.empty() ? static_cast<std::int64_t>(i) : cells.ids[i]};
}

}  // namespace

void check_cells(const CellArrays& cells) {
  const std::size_t n = cells.size();
  check_types(cells.types);
  check_indices(cells.connectivity, "connectivity");
  check_offsets(cells.offsets, n, cells.connectivity.size(), "offsets");
  check_length(cells.ids.size(), n, "ids");
  check_length(cells.objects.size(), n, "objects");
  check_indices(cells.faces, "faces");
  if (!cells.face_offsets.empty() || !cells.faces.empty())
    check_offsets(cells.face_offsets, n, cells.faces.size(), "face_offsets");
}

std::vector<ElementSpec> elements_of(const CellArrays& cells) {
  check_cells(cells);
  std::vector<ElementSpec> elements;
  elements.reserve(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) elements.push_back(element(cells, i));
  return elements;
}

Mesh mesh_of(Index vertices, const CellArrays& cells) {
  check_cells(cells);
  Mesh mesh;
  mesh.add_vertices(vertices);
  for (std::size_t i = 0; i < cells.size(); ++i) mesh.add_element(element(cells, i));
  return mesh;
}

}  // namespace volccd
