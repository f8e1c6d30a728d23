// Arguments of the C interface as the library's types. All functions throw ArgumentError, which names the argument.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>

#include <fmt/format.h>

#include <volccd/capi/volccd.h>
#include <volccd/capi/guard.hpp>
#include <volccd/mesh/cell_arrays.hpp>
#include <volccd/pipelines/detector.hpp>

namespace volccd::capi {

/// The object behind a pointer that must not be NULL.
template <class T>
T& object_of(const char* name, T* pointer) {
  if (!pointer) throw ArgumentError(fmt::format("{} is NULL", name));
  return *pointer;
}

/// A size that must not be negative, nor greater than that of an array of values of `bytes` bytes.
inline std::size_t size_of(const char* name, std::int64_t size, std::size_t bytes = 1) {
  if (size < 0) throw ArgumentError(fmt::format("{}: {} is negative", name, size));
  if (static_cast<std::uint64_t>(size) >=
      static_cast<std::uint64_t>(std::numeric_limits<std::ptrdiff_t>::max()) / bytes)
    throw ArgumentError(fmt::format("{}: {} is more than an array can have", name, size));
  return static_cast<std::size_t>(size);
}

/// An array that must not be NULL unless it has no values.
template <class T>
std::span<const T> array_of(const char* name, const T* data, std::size_t size) {
  if (!data && size != 0) throw ArgumentError(fmt::format("{} is NULL, for {} values", name, size));
  return {data, size};
}

/// `n` positions from 3 n values.
std::span<const Vec3> points_of(const char* name, const double* values, std::size_t n);

/// A number of vertices that the present ones leave room for.
Index vertex_count_of(const char* name, std::int64_t count, Index present, bool thickened);

/// Views of the arrays of the cells; their values are checked by the library.
CellArrays cells_of(const char* name, const volccd_cells& cells);
std::span<const double> thickness_of(const char* name, const volccd_cells& cells);

DetectorConfig config_of(const volccd_options& options);
Request request_of(std::int32_t flags);

}  // namespace volccd::capi
