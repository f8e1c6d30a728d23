// The parts of the extension module; each has a source of its own.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

namespace volccd::python {

namespace py = pybind11;

void bind_errors(py::module_& module);
void bind_cells(py::module_& module);
void bind_results(py::module_& module);
void bind_registry(py::module_& module);
void bind_detector(py::module_& module);
void bind_distributed(py::module_& module);
void bind_sequence(py::module_& module);
void bind_scenes(py::module_& module);
void bind_verify(py::module_& module);
void bind_program(py::module_& module);

}  // namespace volccd::python
