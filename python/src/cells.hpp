// Cells from and to arrays.
#pragma once

#include <volccd/mesh/sequence/cells.hpp>

#include "bind.hpp"

namespace volccd::python {

/// From the arrays of a `_core.Cells`-like dict: types, offsets, connectivity, objects, ids, face_offsets, faces
/// (volccd/_meshes.py). Throws InputError: lengths that do not fit, types that a mesh cannot hold, offsets that do not
/// ascend. What Mesh::add_element checks is not checked here.
SequenceCells cells_from(const py::dict& arrays);

/// The same arrays, copied.
py::dict cells_to(const SequenceCells& cells);

}  // namespace volccd::python
