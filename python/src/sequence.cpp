// Sequence files: their contents, and their steps one after another.
#include <optional>

#include <pybind11/stl.h>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/io/sequence/reader.hpp>
#include <volccd/io/sequence/stepper.hpp>

#include "arrays.hpp"
#include "cells.hpp"
#include "registry.hpp"
#include "runner.hpp"
#include "sequence.hpp"
#include "signals.hpp"

namespace volccd::python {

namespace {

SequenceStepper::Config stepper_config(const py::dict& options) {
  SequenceStepper::Config config;
  const auto choose = [&](const char* name, auto& value) {
    value = value_named<std::decay_t<decltype(value)>>(options[name].template cast<std::string>(), name);
  };
  choose("shells", config.shells);
  choose("edges", config.edge_set);
  choose("motion", config.motion);
  choose("objects", config.objects);
  return config;
}

py::dict metadata_of(const SequenceMetadata& m) {
  return py::dict(py::arg("title") = m.title, py::arg("source") = m.source, py::arg("license") = m.license,
                  py::arg("units") = m.units, py::arg("time_unit") = m.time_unit,
                  py::arg("object_names") = py::cast(m.object_names), py::arg("incomplete") = m.incomplete);
}

py::array points_array(const std::vector<Vec3>& points) {
  return new_array({points.size(), 3}, reinterpret_cast<const double*>(points.data()));
}

}  // namespace

Sequence::Sequence(const std::string& file, const py::dict& options)
    : reader_(file),
      config_(stepper_config(options)),
      stepper_(reader_.frame_count() > 1 ? std::make_unique<SequenceStepper>(reader_, config_) : nullptr) {}

void Sequence::go_to(int step, Executor& executor) {
  if (!stepper_) throw InputError(reader_.file(), "VTKHDF/Steps", "has one frame only, and therefore no step");
  stepper_->go_to(step, executor);
}

SequenceRunner::SequenceRunner(const py::dict& options, bool leave_out_shell_neighbours)
    : SequenceRunner(detector_config(options), leave_out_shell_neighbours) {}

SequenceRunner::SequenceRunner(const DetectorConfig& config, bool leave_out_shell_neighbours)
    : executor_(make_signal_executor(config.threads)),
      runner_(Pipeline(registry(), registry().pipeline(config.pipeline, config.settings)),
              {.executor = executor_.get(),
               .separation = config.separation,
               .filter = config.filter,
               .leave_out_shell_neighbours = leave_out_shell_neighbours,
               .lists = config.lists}) {}

std::shared_ptr<Result> SequenceRunner::run(Sequence& sequence, int step, const StepRequest& request) {
  const BusyGuard guard(busy_, "run of a sequence");
  const BusyGuard sequence_guard(sequence.busy, "Sequence");
  const py::gil_scoped_release without_gil;
  sequence.go_to(step, runner_.executor());
  runner_.run(sequence.stepper().topology(), sequence.stepper().motion(), request.request(), request.t_max);
  return make_result(runner_);
}

namespace {

/// While such an object exists, only this thread may use the reader.
class FrameReading {
 public:
  FrameReading(Sequence& sequence, int frame) : guard_(sequence.busy, "Sequence") {
    const int frames = sequence.reader().frame_count();
    if (frame < 0 || frame >= frames)
      throw InputError(sequence.reader().file(), "VTKHDF/Steps",
                       fmt::format("frame {} is not within 0:{}", frame, frames));
  }

 private:
  BusyGuard guard_;
};

py::array read_points(Sequence& sequence, int frame) {
  const FrameReading reading(sequence, frame);
  std::vector<Vec3> points;
  sequence.reader().read_points(frame, points);
  return points_array(points);
}

py::object read_velocity(Sequence& sequence, int frame) {
  const FrameReading reading(sequence, frame);
  if (!sequence.reader().has_velocity()) return py::none();
  std::vector<Vec3> velocity;
  sequence.reader().read_velocity(frame, velocity);
  return points_array(velocity);
}

py::object read_thickness(Sequence& sequence, int frame) {
  const FrameReading reading(sequence, frame);
  if (!sequence.reader().has_thickness()) return py::none();
  std::vector<double> thickness;
  sequence.reader().read_thickness(frame, thickness);
  return new_array({thickness.size()}, thickness.data());
}

py::dict read_cells(Sequence& sequence, int frame) {
  const FrameReading reading(sequence, frame);
  SequenceCells cells;
  sequence.reader().read_cells(frame, cells);
  return cells_to(cells);
}

py::array times(const Sequence& sequence) {
  std::vector<double> values;
  for (int frame = 0; frame < sequence.reader().frame_count(); ++frame) values.push_back(sequence.reader().time(frame));
  return new_array({values.size()}, values.data());
}

/// Element ids by slot of the current topology of the sequence; -1 if a slot is empty.
py::array element_ids(Sequence& sequence) {
  const BusyGuard guard(sequence.busy, "Sequence");
  if (sequence.step() < 0)
    throw InputError(sequence.reader().file(), "", "detect() has not run on a step yet: there are no elements");
  const Mesh& mesh = sequence.stepper().topology().mesh();
  std::vector<std::int64_t> ids(mesh.element_slots());
  for (Index o = 0; o < mesh.element_slots(); ++o) ids[o] = mesh.is_live(o) ? mesh.element_id(o) : -1;
  return new_array({ids.size()}, ids.data());
}

}  // namespace

void bind_sequence(py::module_& module) {
  using namespace pybind11::literals;
  py::class_<Sequence>(module, "Sequence")
      .def(py::init<const std::string&, const py::dict&>())
      .def_property_readonly("file", [](const Sequence& s) { return s.reader().file(); })
      .def_property_readonly("metadata", [](const Sequence& s) { return metadata_of(s.reader().metadata()); })
      .def_property_readonly("frame_count", [](const Sequence& s) { return s.reader().frame_count(); })
      .def_property_readonly("point_count", [](const Sequence& s) { return s.reader().point_count(); })
      .def_property_readonly("point_ids",
                             [](const Sequence& s) {
                               const auto ids = s.reader().point_ids();
                               return new_array({ids.size()}, ids.data());
                             })
      .def_property_readonly("times", &times)
      .def_property_readonly("element_ids", &element_ids)
      .def("points", &read_points, "step"_a)
      .def("velocity", &read_velocity, "step"_a)
      .def("thickness", &read_thickness, "step"_a)
      .def("cells", &read_cells, "step"_a);
  py::class_<SequenceRunner>(module, "SequenceRunner")
      .def(py::init<const py::dict&, bool>(), "options"_a, "leave_out_shell_neighbours"_a)
      .def(
          "run",
          [](SequenceRunner& runner, Sequence& sequence, int step, bool first, bool overlaps, double t_max) {
            return runner.run(sequence, step, {first, overlaps, t_max});
          },
          "sequence"_a, "step"_a, "first"_a, "initial_overlaps"_a, "t_max"_a)
      .def_property_readonly(
          "facts", [](const SequenceRunner& r) { return facts_of(r.runner().pipeline(), r.runner().executor()); });
}

}  // namespace volccd::python
