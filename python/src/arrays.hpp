// Conversions between NumPy arrays and the library's types.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include <volccd/numerics/types.hpp>
#include <volccd/query/pairs.hpp>

#include "bind.hpp"

namespace volccd::python {

/// An argument of doubles. It is used in place if it is float64 and C-contiguous, otherwise converted once.
using DoubleArray = py::array_t<double, py::array::c_style | py::array::forcecast>;
template <class T>
using IntegerArray = py::array_t<T, py::array::c_style>;

/// The rows of an array [n, 3], in place; valid while the array lives. Throws InputError naming `name` for another
/// shape.
std::span<const Vec3> points_of(const DoubleArray& array, const char* name);

/// The values of an array [n]. Throws InputError naming `name` for another shape.
template <class T, int Flags>
std::span<const T> values_of(const py::array_t<T, Flags>& array, const char* name);

/// A new array with a copy of `data`; its dtype is that of the C++ type T. Allocates through Python only, so that
/// stages in Python keep the promise not to allocate (docs/python.md). The GIL must be held.
template <class T>
py::array new_array(std::initializer_list<std::size_t> shape, const T* data);

/// Views of memory that `owner` keeps alive.
py::array view(const py::dtype& dtype, std::size_t n, const void* data, const py::handle& owner);

/// Pairs a, b as uint32, as ElementPair has them in memory.
py::dtype pair_dtype();

// Definitions.

[[noreturn]] void wrong_shape(const char* name, const std::string& expected);
py::array new_array(const py::dtype& dtype, std::initializer_list<std::size_t> shape, const void* data,
                    std::size_t bytes);

template <class T, int Flags>
std::span<const T> values_of(const py::array_t<T, Flags>& array, const char* name) {
  if (array.ndim() != 1) wrong_shape(name, "one dimension");
  return {array.data(), static_cast<std::size_t>(array.size())};
}

template <class T>
py::array new_array(std::initializer_list<std::size_t> shape, const T* data) {
  std::size_t size = 1;
  for (const std::size_t n : shape) size *= n;
  return new_array(py::dtype::of<T>(), shape, data, size * sizeof(T));
}

}  // namespace volccd::python
