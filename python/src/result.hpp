// What a run gives to Python.
#pragma once

#include <volccd/pipelines/pipeline.hpp>

#include "bind.hpp"

namespace volccd::python {

/// Lies in memory that Python owns; its arrays are views of it.
struct Result : StepResult {
  py::object statistics_dict;  ///< made when it is asked for first; empty until then
};

/// A structured array of contacts; a view, `owner` keeps it alive.
py::array contacts_view(const std::vector<Contact>& contacts, const py::handle& owner);
/// The same, copied.
py::array contacts_copy(const std::vector<Contact>& contacts);
py::array pairs_copy(const std::vector<ElementPair>& pairs);

/// Counts, seconds, and under "stages" a structured array.
py::dict statistics_dict(const Statistics& statistics);

}  // namespace volccd::python
