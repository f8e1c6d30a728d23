#include "cells.hpp"

#include <fmt/format.h>

#include <volccd/core/error.hpp>

#include "arrays.hpp"

namespace volccd::python {

namespace {

template <class T>
std::span<const T> take(const py::dict& arrays, const char* name, py::object& keep) {
  const auto array = IntegerArray<T>::ensure(arrays[name]);
  if (!array) throw py::error_already_set();
  keep = array;
  return values_of(array, name);
}

/// Offsets into `length` values: they begin with 0, ascend, and end with `length`.
std::vector<std::size_t> offsets_from(std::span<const std::int64_t> offsets, std::size_t cells, std::size_t length,
                                      const char* name) {
  if (offsets.size() != cells + 1)
    throw InputError("cells", name, fmt::format("{} cells need {} offsets, not {}", cells, cells + 1, offsets.size()));
  for (std::size_t i = 0; i < offsets.size(); ++i)
    if (offsets[i] < (i == 0 ? 0 : offsets[i - 1]) || static_cast<std::size_t>(offsets[i]) > length)
      throw InputError("cells", name, static_cast<std::int64_t>(i),
                       "offsets must ascend within the connectivity, from 0 on");
  if (offsets.front() != 0 || static_cast<std::size_t>(offsets.back()) != length)
    throw InputError("cells", name, "offsets must begin with 0 and end with the length of the connectivity");
  return {offsets.begin(), offsets.end()};
}

std::vector<ElementType> types_from(std::span<const std::uint8_t> types) {
  std::vector<ElementType> result(types.size());
  for (std::size_t i = 0; i < types.size(); ++i) {
    if (!is_element_type(types[i]))
      throw InputError("cells", "types", static_cast<std::int64_t>(i),
                       fmt::format("VTK cell type {} is none that a mesh can hold: triangle 5, quad 9, tetrahedron 10, "
                                   "hexahedron 12, wedge 13, pyramid 14, polyhedron 42",
                                   types[i]));
    result[i] = static_cast<ElementType>(types[i]);
  }
  return result;
}

/// Vertex numbers of 64 bits. A face stream also contains counts.
std::vector<Index> indices_from(std::span<const std::int64_t> values, const char* name) {
  std::vector<Index> result(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] < 0 || values[i] >= static_cast<std::int64_t>(kNone))
      throw InputError("cells", name, static_cast<std::int64_t>(i),
                       fmt::format("{} is not the number of a point", values[i]));
    result[i] = static_cast<Index>(values[i]);
  }
  return result;
}

template <class To, class From>
std::vector<To> copied(std::span<const From> values, std::size_t cells, const char* name) {
  if (values.size() != cells)
    throw InputError("cells", name, fmt::format("{} cells need {} values, not {}", cells, cells, values.size()));
  return {values.begin(), values.end()};
}

}  // namespace

SequenceCells cells_from(const py::dict& arrays) {
  py::object keep;
  SequenceCells cells;
  cells.types = types_from(take<std::uint8_t>(arrays, "types", keep));
  const std::size_t n = cells.types.size();
  cells.connectivity = indices_from(take<std::int64_t>(arrays, "connectivity", keep), "connectivity");
  cells.offsets = offsets_from(take<std::int64_t>(arrays, "offsets", keep), n, cells.connectivity.size(), "offsets");
  cells.objects = copied<std::int32_t>(take<std::int32_t>(arrays, "objects", keep), n, "objects");
  cells.ids = copied<std::int64_t>(take<std::int64_t>(arrays, "ids", keep), n, "ids");
  if (arrays["face_offsets"].is_none()) return cells;
  cells.faces = indices_from(take<std::int64_t>(arrays, "faces", keep), "faces");
  cells.face_offsets =
      offsets_from(take<std::int64_t>(arrays, "face_offsets", keep), n, cells.faces.size(), "face_offsets");
  return cells;
}

py::dict cells_to(const SequenceCells& cells) {
  static_assert(sizeof(ElementType) == 1);
  py::dict arrays;
  arrays["types"] = new_array({cells.size()}, reinterpret_cast<const std::uint8_t*>(cells.types.data()));
  arrays["offsets"] = new_array({cells.offsets.size()}, cells.offsets.data()).attr("astype")("int64");
  arrays["connectivity"] = new_array({cells.connectivity.size()}, cells.connectivity.data()).attr("astype")("int64");
  arrays["objects"] = new_array({cells.objects.size()}, cells.objects.data());
  arrays["ids"] = new_array({cells.ids.size()}, cells.ids.data());
  arrays["face_offsets"] = py::none();
  arrays["faces"] = py::none();
  if (cells.face_offsets.empty()) return arrays;
  arrays["face_offsets"] = new_array({cells.face_offsets.size()}, cells.face_offsets.data()).attr("astype")("int64");
  arrays["faces"] = new_array({cells.faces.size()}, cells.faces.data()).attr("astype")("int64");
  return arrays;
}

void bind_cells(py::module_& module) {
  module.def(
      "check_cells",
      [](const py::dict& arrays, Index points) {
        std::vector<std::int64_t> ids(points);
        for (Index v = 0; v < points; ++v) ids[v] = v;
        mesh_of(ids, cells_from(arrays));
      },
      "Raises InputError if these cells on this many points are no mesh.");
}

}  // namespace volccd::python
