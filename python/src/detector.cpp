// A mesh given by arrays, and its steps.
#include <algorithm>
#include <numeric>
#include <optional>

#include <pybind11/stl.h>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/mesh/shells.hpp>

#include "arrays.hpp"
#include "cells.hpp"
#include "runner.hpp"
#include "signals.hpp"

namespace volccd::python {

namespace {

std::vector<std::int64_t> numbers(Index n) {
  std::vector<std::int64_t> ids(n);
  std::iota(ids.begin(), ids.end(), std::int64_t{0});
  return ids;
}

EdgeSet edges_from(const std::string& edges) {
  if (edges == "triangulated") return EdgeSet::triangulated;
  if (edges == "polytope") return EdgeSet::polytope;
  throw ConfigError(fmt::format("edges: '{}' is not triangulated or polytope", edges));
}

/// The shells of a mesh with their thickness, and the solid elements made from them.
class Shells {
 public:
  Shells(Mesh mesh, std::vector<double> thickness)
      : mesh_(std::move(mesh)), thickness_(std::move(thickness)), thickener_(mesh_) {}

  Mesh solids() const { return thickener_.solid_mesh(mesh_); }
  Index vertex_count() const { return mesh_.vertex_count(); }

  void positions(std::span<const Vec3> x, std::vector<Vec3>& out, Executor& executor) {
    thickener_.positions(x, thickness_, out, scratch_, executor);
  }

  /// Updates the shells after an edit; `thickness` has one value for each added element.
  Shells edited(std::span<const Index> removed, Index new_vertices, const std::vector<ElementSpec>& added,
                std::span<const double> thickness) const {
    Mesh mesh = mesh_;
    std::vector<double> values = thickness_;
    for (const Index slot : removed) mesh.remove_element(slot);
    mesh.add_vertices(new_vertices);
    for (std::size_t i = 0; i < added.size(); ++i) {
      const Index slot = mesh.add_element(added[i]);
      if (slot >= values.size()) values.resize(slot + 1, 0.0);
      values[slot] = thickness[i];
    }
    return Shells(std::move(mesh), std::move(values));
  }

  const Mesh& mesh() const { return mesh_; }

 private:
  Mesh mesh_;
  std::vector<double> thickness_;  ///< by slot
  ShellThickener thickener_;
  ShellThickener::Scratch scratch_;
};

class Detector {
 public:
  Detector(const py::dict& cells, Index vertices, const std::optional<DoubleArray>& thickness, const std::string& edges,
           const py::dict& options)
      : runner_(RunnerConfig(options)) {
    const SequenceCells given = cells_from(cells);
    const EdgeSet edge_set = edges_from(edges);
    std::span<const double> values;
    if (thickness) values = values_of(*thickness, "thickness");
    const py::gil_scoped_release without_gil;
    Mesh mesh = mesh_of(numbers(vertices), given);
    if (thickness) {
      shells_.emplace(std::move(mesh), std::vector<double>(values.begin(), values.end()));
      mesh = shells_->solids();
    }
    topology_.emplace(std::move(mesh), runner_.executor(), edge_set);
  }

  std::shared_ptr<Result> step(const DoubleArray& points0, const DoubleArray& points1,
                               const std::optional<DoubleArray>& middle, bool first, bool initial_overlaps,
                               double t_max) {
    const BusyGuard guard(busy_, "Detector");
    const std::span<const Vec3> x0 = points_of(points0, "points0"), x1 = points_of(points1, "points1");
    std::optional<std::span<const Vec3>> xm;
    if (middle) xm = points_of(*middle, "middle");
    const py::gil_scoped_release without_gil;
    set_motion(x0, x1, xm);
    return runner_.run(*topology_, motion_, {first, initial_overlaps, t_max}, shells_.has_value());
  }

  void edit(const IntegerArray<std::int64_t>& removed, Index new_vertices, const py::dict& added,
            const std::optional<DoubleArray>& thickness) {
    const BusyGuard guard(busy_, "Detector");
    TopologyEdit edit;
    const SequenceCells cells = cells_from(added);
    for (std::size_t i = 0; i < cells.size(); ++i) edit.added.push_back(cells.spec(i));
    const Mesh& mesh = shells_ ? shells_->mesh() : topology_->mesh();
    edit.removed = slots_of(mesh, values_of(removed, "remove"));
    if (shells_) return edit_shells(edit, new_vertices, thickness);
    for (Index i = 0; i < new_vertices; ++i) edit.new_vertex_ids.push_back(std::int64_t{mesh.vertex_count()} + i);
    topology_->apply(edit);
  }

  /// Ids by slot; -1 if a slot is empty.
  py::array element_ids() const {
    const Mesh& mesh = topology_->mesh();
    std::vector<std::int64_t> ids(mesh.element_slots());
    for (Index o = 0; o < mesh.element_slots(); ++o) ids[o] = mesh.is_live(o) ? mesh.element_id(o) : -1;
    return new_array({ids.size()}, ids.data());
  }

  Index vertex_count() const { return shells_ ? shells_->vertex_count() : topology_->mesh().vertex_count(); }
  const Topology& topology() const { return *topology_; }
  Runner& runner() { return runner_; }

 private:
  static std::vector<Index> slots_of(const Mesh& mesh, std::span<const std::int64_t> ids) {
    std::vector<Index> slots;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      slots.push_back(mesh.find_element(ids[i]));
      if (slots.back() == kNone)
        throw InputError("edit", "remove", static_cast<std::int64_t>(i), fmt::format("there is no element {}", ids[i]));
    }
    std::vector<Index> sorted = slots;
    std::sort(sorted.begin(), sorted.end());
    if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end())
      throw InputError("edit", "remove", "an element is named twice");
    return slots;
  }

  void set_motion(std::span<const Vec3> x0, std::span<const Vec3> x1, std::optional<std::span<const Vec3>> xm) {
    if (shells_) {
      if (xm) throw ConfigError("middle: thickened shells move on straight lines");
      shells_->positions(x0, solid0_, runner_.executor());
      shells_->positions(x1, solid1_, runner_.executor());
      motion_.set_linear(solid0_, solid1_);
    } else if (xm) {
      motion_ = Motion::quadratic(x0, *xm, x1);
    } else {
      motion_.set_linear(x0, x1);
    }
  }

  void edit_shells(const TopologyEdit& edit, Index new_vertices, const std::optional<DoubleArray>& thickness) {
    if (!thickness && !edit.added.empty())
      throw InputError("edit", "thickness", "the Detector has thickened shells: added cells need a thickness");
    std::span<const double> values;
    if (thickness) values = values_of(*thickness, "thickness");
    if (values.size() != edit.added.size())
      throw InputError("edit", "thickness", fmt::format("{} for {} cells", values.size(), edit.added.size()));
    Shells edited = shells_->edited(edit.removed, new_vertices, edit.added, values);
    TopologyEdit solid = edit_to(topology_->mesh(), cells_of(edited.solids()));
    for (Index i = 0; i < 3 * new_vertices; ++i)
      solid.new_vertex_ids.push_back(std::int64_t{topology_->mesh().vertex_count()} + i);
    topology_->apply(solid);
    shells_.emplace(std::move(edited));
  }

  Runner runner_;
  std::optional<Shells> shells_;
  std::optional<Topology> topology_;
  Motion motion_;
  std::vector<Vec3> solid0_, solid1_;
  bool busy_ = false;
};

}  // namespace

void bind_detector(py::module_& module) {
  using namespace pybind11::literals;
  py::class_<Detector>(module, "Detector")
      .def(py::init<const py::dict&, Index, const std::optional<DoubleArray>&, const std::string&, const py::dict&>())
      .def("step", &Detector::step, "points0"_a, "points1"_a, "middle"_a, "first"_a, "initial_overlaps"_a, "t_max"_a)
      .def("edit", &Detector::edit)
      .def_property_readonly("element_ids", &Detector::element_ids)
      .def_property_readonly("vertex_count", &Detector::vertex_count)
      .def_property_readonly("element_count", [](const Detector& d) { return d.topology().mesh().element_count(); })
      .def_property_readonly("edge_count", [](const Detector& d) { return d.topology().features().edge_count(); })
      .def_property_readonly("triangle_count",
                             [](const Detector& d) { return d.topology().features().triangle_count(); })
      .def_property(
          "separation", [](Detector& d) { return d.runner().separation(); },
          [](Detector& d, double separation) { d.runner().set_separation(separation); })
      .def_property_readonly("facts", [](Detector& d) { return runner_facts(d.runner()); });
}

}  // namespace volccd::python
