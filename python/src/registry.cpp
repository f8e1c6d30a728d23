#include "registry.hpp"

#include <pybind11/stl.h>

#include <volccd/paper2011/paper2011.hpp>
#include <volccd/peers/peers.hpp>
#include <volccd/pipelines/pipeline.hpp>

#include "stages.hpp"

namespace volccd::python {

namespace {

Registry standard() {
  Registry made = Registry::standard();
  add_paper2011(made);
  add_peers(made);
  return made;
}

/// The registry is never destroyed, because its stages refer to Python objects.
Registry*& current() {
  static Registry* made = new Registry(standard());
  return made;
}

/// Replaces the registry. `stages` are classes (volccd/_stages.py), `pipelines` are tuples (name, base, settings,
/// description). If an exception is thrown, the registry is unchanged.
void set_registry(const py::list& stages, const py::list& pipelines) {
  Registry made = standard();
  for (const py::handle stage : stages) add_stage(made, py::reinterpret_borrow<py::object>(stage));
  for (const py::handle row : pipelines) {
    const py::tuple parts = py::reinterpret_borrow<py::tuple>(row);
    PipelineSpec spec = made.pipeline(parts[1].cast<std::string>(), parts[2].cast<std::vector<std::string>>());
    spec.name = parts[0].cast<std::string>();
    spec.description = parts[3].cast<std::string>();
    Pipeline(made, spec);  // errors are thrown now
    made.add_pipeline(std::move(spec));
  }
  *current() = std::move(made);
}

template <class Stage>
void list_role(py::list& rows) {
  for (const StageDescriptor<Stage>& stage : registry().stages<Stage>()) {
    py::dict options;
    for (const OptionInfo& option : stage.options)
      options[py::str(option.name)] =
          py::dict(py::arg("default") = option.default_value, py::arg("allowed") = option.allowed,
                   py::arg("description") = option.description);
    rows.append(py::dict(py::arg("name") = stage.name, py::arg("role") = Stage::kRole,
                         py::arg("guarantee") = to_string(stage.guarantee), py::arg("description") = stage.description,
                         py::arg("options") = options));
  }
}

py::list list_stages() {
  py::list rows;
  list_role<BroadPhase>(rows);
  list_role<ElementCulling>(rows);
  list_role<Assignment>(rows);
  list_role<OrphanSource>(rows);
  list_role<Flood>(rows);
  list_role<FeatureFilter>(rows);
  list_role<NarrowPhase>(rows);
  return rows;
}

py::dict list_pipelines() {
  py::dict rows;
  for (const PipelineSpec& spec : registry().pipelines()) rows[py::str(spec.name)] = spec.description;
  return rows;
}

}  // namespace

const Registry& registry() { return *current(); }

void bind_registry(py::module_& module) {
  module.def("set_registry", &set_registry);
  module.def("stages", &list_stages);
  module.def("pipelines", &list_pipelines);
}

}  // namespace volccd::python
