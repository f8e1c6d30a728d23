// A mesh given by arrays, and its steps: the library's Detector.
#include <optional>

#include <pybind11/stl.h>

#include "arrays.hpp"
#include "cells.hpp"
#include "registry.hpp"
#include "runner.hpp"
#include "signals.hpp"

namespace volccd::python {

namespace {

/// A volccd::Detector whose executor looks for signals.
class SignalDetector {
 public:
  SignalDetector(const py::dict& cells, Index vertices, const std::optional<DoubleArray>& thickness,
                 const std::string& edges, const py::dict& options) {
    const PythonCells arrays(cells);
    const Registry stages = registry();  // which may change when the GIL is released
    DetectorConfig config = detector_config(options);
    config.edge_set = value_named<EdgeSet>(edges, "edges");
    executor_ = make_signal_executor(config.threads);
    config.executor = executor_.get();
    std::span<const double> values;
    if (thickness) values = values_of(*thickness, "thickness");
    const py::gil_scoped_release without_gil;
    if (thickness)
      detector_.emplace(mesh_of(vertices, arrays.views()), values, config, stages);
    else
      detector_.emplace(mesh_of(vertices, arrays.views()), config, stages);
  }

  std::shared_ptr<Result> step(const DoubleArray& points0, const DoubleArray& points1,
                               const std::optional<DoubleArray>& middle, bool first, bool initial_overlaps,
                               double t_max, bool ends) {
    const BusyGuard guard(busy_, "Detector");
    const StepRequest asked{first, initial_overlaps, t_max, ends};
    const std::span<const Vec3> x0 = points_of(points0, "points0"), x1 = points_of(points1, "points1");
    const std::span<const Vec3> xm = middle ? points_of(*middle, "middle") : std::span<const Vec3>();
    const py::gil_scoped_release without_gil;
    if (middle)
      detector_->step(x0, xm, x1, asked.request(), t_max);
    else
      detector_->step(x0, x1, asked.request(), t_max);
    return make_result(*detector_);
  }

  void edit(const IntegerArray<std::int64_t>& removed, Index new_vertices, const py::dict& added,
            const std::optional<DoubleArray>& thickness) {
    const BusyGuard guard(busy_, "Detector");
    DetectorEdit edit{.new_vertices = new_vertices, .added = elements_of(PythonCells(added).views())};
    const auto copy = [](auto values, auto& to) { to.assign(values.begin(), values.end()); };
    copy(values_of(removed, "remove"), edit.removed);
    if (thickness) copy(values_of(*thickness, "thickness"), edit.thickness);
    detector_->edit(edit);
  }

  /// Ids by slot; -1 if a slot is empty.
  py::array element_ids() const {
    const Mesh& mesh = detector_->topology().mesh();
    std::vector<std::int64_t> ids(mesh.element_slots());
    for (Index o = 0; o < mesh.element_slots(); ++o) ids[o] = mesh.is_live(o) ? mesh.element_id(o) : -1;
    return new_array({ids.size()}, ids.data());
  }

  Detector& detector() { return *detector_; }

 private:
  std::unique_ptr<Executor> executor_;
  std::optional<Detector> detector_;
  bool busy_ = false;
};

}  // namespace

void bind_detector(py::module_& module) {
  using namespace pybind11::literals;
  using Self = SignalDetector;
  py::class_<Self>(module, "Detector")
      .def(py::init<const py::dict&, Index, const std::optional<DoubleArray>&, const std::string&, const py::dict&>())
      .def("step", &Self::step, "points0"_a, "points1"_a, "middle"_a, "first"_a, "initial_overlaps"_a, "t_max"_a,
           "ends"_a)
      .def("edit", &Self::edit)
      .def_property_readonly("element_ids", &Self::element_ids)
      .def_property_readonly("vertex_count", [](Self& d) { return d.detector().mesh().vertex_count(); })
      .def_property_readonly("element_count", [](Self& d) { return d.detector().mesh().element_count(); })
      .def_property_readonly("edge_count", [](Self& d) { return d.detector().topology().features().edge_count(); })
      .def_property_readonly("triangle_count",
                             [](Self& d) { return d.detector().topology().features().triangle_count(); })
      .def_property(
          "separation", [](Self& d) { return d.detector().separation(); },
          [](Self& d, double separation) { d.detector().set_separation(separation); })
      .def_property_readonly("facts",
                             [](Self& d) { return facts_of(d.detector().pipeline(), d.detector().executor()); });
}

}  // namespace volccd::python
