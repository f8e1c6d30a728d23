// Conversions between cells and arrays.
#pragma once

#include <vector>

#include <volccd/io/sequence/cells.hpp>
#include <volccd/mesh/cell_arrays.hpp>

#include "bind.hpp"

namespace volccd::python {

/// The arrays of a `_core.Cells`-like dict as views, which are valid while the object lives: types, offsets,
/// connectivity, objects, ids, face_offsets, faces (volccd/_meshes.py). The library checks their values.
class PythonCells {
 public:
  /// Throws InputError for an array that does not have one dimension. The GIL must be held, also at the destruction.
  explicit PythonCells(const py::dict& arrays);

  const CellArrays& views() const { return views_; }

 private:
  template <class T>
  std::span<const T> take(const py::dict& arrays, const char* name);

  std::vector<py::object> arrays_;
  CellArrays views_;
};

/// The same arrays, copied.
py::dict cells_to(const SequenceCells& cells);

}  // namespace volccd::python
