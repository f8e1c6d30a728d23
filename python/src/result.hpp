// The results of a run as Python objects.
#pragma once

#include <volccd/distributed/result.hpp>
#include <volccd/pipelines/pipeline.hpp>

#include "bind.hpp"

namespace volccd::python {

/// The data are in memory that Python owns; the arrays are views of it.
struct Result : StepResult {
  explicit Result(StepResult&& result) : StepResult(std::move(result)) {}

  py::object statistics_dict;  ///< made at the first use; empty until then
};

/// A structured array of contacts, as a view; `owner` keeps the memory alive.
py::array contacts_view(const std::vector<Contact>& contacts, const py::handle& owner);
/// The same as a copy.
py::array contacts_copy(const std::vector<Contact>& contacts);
/// Contacts of a rank, whose vertices and elements are ids.
py::array rank_contacts_copy(const std::vector<distributed::RankContact>& contacts);
py::dtype rank_contacts_dtype();
py::array pairs_copy(const std::vector<ElementPair>& pairs);

/// Counts, seconds, and a structured array under "stages".
py::dict statistics_dict(const Statistics& statistics);

}  // namespace volccd::python
