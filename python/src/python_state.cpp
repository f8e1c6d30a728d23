#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include <volccd/core/error.hpp>

#include "arrays.hpp"
#include "stages.hpp"

namespace volccd::python {

SharedObject::SharedObject(py::object object)
    : object_(new py::object(std::move(object)), [](py::object* held) {
        if (!Py_IsInitialized()) return;  // the interpreter has ended, and its objects no longer exist
        const py::gil_scoped_acquire gil;
        delete held;
      }) {}

PythonState::PythonState() : step_(py::module_::import("volccd._stages").attr("Step")()) {}

void PythonState::prepare(const Step& step, const SharedObject& stage) {
  const py::gil_scoped_acquire gil;
  const py::object& view = step_.get();
  if (version_ != step.topology.version()) set_elements(step.mesh());
  version_ = step.topology.version();
  const std::size_t n = step.motion.vertex_count(), points = static_cast<std::size_t>(step.motion.control_points());
  const py::array control_points = new_array({n, points, 3}, n == 0 ? nullptr : step.motion.at(0));
  bytes_ = n * points * 3 * sizeof(double);
  view.attr("control_points") = control_points;
  view.attr("separation") = step.separation;
  view.attr("t_max") = step.t_max;
  stage.get().attr("prepare")(view);
}

void PythonState::set_elements(const Mesh& mesh) {
  const Index slots = mesh.element_slots();
  std::size_t width = 1;
  for (Index o = 0; o < slots; ++o) width = std::max(width, mesh.vertices(o).size());
  std::vector<Index> corners(slots * width, 0);
  std::vector<std::uint8_t> types(slots);
  std::vector<std::int32_t> objects(slots, 0);
  for (Index o = 0; o < slots; ++o) {
    types[o] = static_cast<std::uint8_t>(mesh.type(o));
    if (!mesh.is_live(o)) continue;
    objects[o] = mesh.object(o);
    const std::span<const Index> vertices = mesh.vertices(o);
    const auto row = corners.begin() + static_cast<std::ptrdiff_t>(o * width);
    std::fill(std::copy(vertices.begin(), vertices.end(), row), row + static_cast<std::ptrdiff_t>(width),
              vertices.back());
  }
  const py::object& view = step_.get();
  view.attr("corners") = new_array({slots, width}, corners.data());
  view.attr("types") = new_array({slots}, types.data());
  view.attr("objects") = new_array({slots}, objects.data());
}

namespace {

[[noreturn]] void wrong_verdicts(const py::object& returned, std::size_t n, const char* method,
                                 const py::object& stage) {
  throw ConfigError(fmt::format(
      "stage '{}': {}() must return an array of the shape ({},) of bool, or of integers in 0 .. 2, "
      "not {}",
      stage.attr("name").cast<std::string>(), method, n, py::repr(returned).cast<std::string>().substr(0, 200)));
}

}  // namespace

py::array verdicts_of(const py::object& returned, std::size_t n, const char* method, const py::object& stage) {
  if (!py::isinstance<py::array>(returned)) wrong_verdicts(returned, n, method, stage);
  py::array array = py::reinterpret_borrow<py::array>(returned);
  const char kind = array.dtype().kind();
  if (array.ndim() != 1 || static_cast<std::size_t>(array.shape(0)) != n || (kind != 'b' && kind != 'i' && kind != 'u'))
    wrong_verdicts(returned, n, method, stage);
  // As doubles, so that integers of any size can be checked.
  if (kind != 'b' && (array.attr("min")().cast<double>() < 0 || array.attr("max")().cast<double>() > 2))
    wrong_verdicts(returned, n, method, stage);
  return py::reinterpret_steal<py::array>(py::detail::npy_api::get().PyArray_FromAny_(
      array.ptr(), py::dtype::of<std::uint8_t>().release().ptr(), 1, 1,
      py::detail::npy_api::NPY_ARRAY_C_CONTIGUOUS_ | py::detail::npy_api::NPY_ARRAY_FORCECAST_, nullptr));
}

}  // namespace volccd::python
