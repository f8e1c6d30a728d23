// Conversions between cells and arrays.
#pragma once

#include <volccd/io/sequence/cells.hpp>

#include "bind.hpp"

namespace volccd::python {

/// Makes cells from the arrays of a `_core.Cells`-like dict: types, offsets, connectivity, objects, ids, face_offsets,
/// faces (volccd/_meshes.py). Throws InputError for lengths that do not match, types that a mesh cannot have, and
/// offsets that do not ascend. The checks of Mesh::add_element are not made here.
SequenceCells cells_from(const py::dict& arrays);

/// The same arrays, copied.
py::dict cells_to(const SequenceCells& cells);

}  // namespace volccd::python
