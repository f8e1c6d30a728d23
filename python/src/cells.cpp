#include "cells.hpp"

#include "arrays.hpp"

namespace volccd::python {

PythonCells::PythonCells(const py::dict& arrays) {
  views_.types = take<std::uint8_t>(arrays, "types");
  views_.offsets = take<std::int64_t>(arrays, "offsets");
  views_.connectivity = take<std::int64_t>(arrays, "connectivity");
  views_.ids = take<std::int64_t>(arrays, "ids");
  views_.objects = take<std::int32_t>(arrays, "objects");
  if (arrays["face_offsets"].is_none()) return;
  views_.face_offsets = take<std::int64_t>(arrays, "face_offsets");
  views_.faces = take<std::int64_t>(arrays, "faces");
}

template <class T>
std::span<const T> PythonCells::take(const py::dict& arrays, const char* name) {
  const auto array = IntegerArray<T>::ensure(arrays[name]);
  if (!array) throw py::error_already_set();
  arrays_.push_back(array);
  return values_of(array, name);
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
      "check_cells", [](const py::dict& arrays, Index points) { mesh_of(points, PythonCells(arrays).views()); },
      "Raises InputError if these cells on this many points are no mesh.");
}

}  // namespace volccd::python
