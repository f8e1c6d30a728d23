#include "arrays.hpp"

#include <array>
#include <cstring>

#include <volccd/core/error.hpp>

namespace volccd::python {

void wrong_shape(const char* name, const std::string& expected) {
  throw InputError("arguments", name, "the array has another shape than expected: " + expected);
}

std::span<const Vec3> points_of(const DoubleArray& array, const char* name) {
  static_assert(sizeof(Vec3) == 3 * sizeof(double) && alignof(Vec3) == alignof(double));
  if (array.ndim() != 2 || array.shape(1) != 3) wrong_shape(name, "(n, 3), one row a point");
  return {reinterpret_cast<const Vec3*>(array.data()), static_cast<std::size_t>(array.shape(0))};
}

py::array new_array(const py::dtype& dtype, std::initializer_list<std::size_t> shape, const void* data,
                    std::size_t bytes) {
  std::array<Py_intptr_t, 4> dimensions{};
  std::size_t n = 0;
  for (const std::size_t length : shape) dimensions[n++] = static_cast<Py_intptr_t>(length);
  const auto& numpy = py::detail::npy_api::get();
  py::dtype type = dtype;
  PyObject* const made = numpy.PyArray_NewFromDescr_(numpy.PyArray_Type_, type.release().ptr(), static_cast<int>(n),
                                                     dimensions.data(), nullptr, nullptr, 0, nullptr);
  if (!made) throw py::error_already_set();
  py::array array = py::reinterpret_steal<py::array>(made);
  if (bytes != 0) std::memcpy(array.mutable_data(), data, bytes);
  return array;
}

py::array view(const py::dtype& dtype, std::size_t n, const void* data, const py::handle& owner) {
  return py::array(dtype, {n}, {static_cast<std::size_t>(dtype.itemsize())}, data, owner);
}

py::dtype pair_dtype() {
  py::list fields;
  fields.append(py::make_tuple("a", "<u4"));
  fields.append(py::make_tuple("b", "<u4"));
  static_assert(sizeof(ElementPair) == 2 * sizeof(Index));
  return py::dtype::from_args(fields);
}

}  // namespace volccd::python
