// The comparison of `volccd verify`.
#include <memory>

#include <pybind11/stl.h>

#include <volccd/experiments/verify/verify.hpp>

#include "arrays.hpp"
#include "registry.hpp"
#include "result.hpp"
#include "sequence.hpp"
#include "signals.hpp"

namespace volccd::python {

namespace {

py::array changed_times(const std::vector<std::pair<Contact, Contact>>& changed) {
  std::vector<Contact> found;
  for (const auto& [expected, contact] : changed) found.push_back(contact);
  return contacts_copy(found);
}

py::dict verdict_of(const PipelineVerdict& one) {
  return py::dict(py::arg("pipeline") = one.pipeline, py::arg("same") = one.agrees(), py::arg("held") = one.held,
                  py::arg("refused") = one.refused, py::arg("missing") = contacts_copy(one.difference.missing),
                  py::arg("extra") = contacts_copy(one.difference.extra),
                  py::arg("changed") = changed_times(one.difference.changed),
                  py::arg("missing_overlaps") = pairs_copy(one.missing_overlaps),
                  py::arg("extra_overlaps") = pairs_copy(one.extra_overlaps),
                  py::arg("statistics") = statistics_dict(one.statistics));
}

py::dict verdict_of(const StepVerdict& step) {
  py::list pipelines;
  for (const PipelineVerdict& one : step.pipelines) pipelines.append(verdict_of(one));
  return py::dict(py::arg("clean") = step.clean(), py::arg("reference") = step.reference,
                  py::arg("contacts") = step.contacts, py::arg("earliest_toi") = step.earliest_toi,
                  py::arg("initial_overlaps") = step.initial_overlaps, py::arg("pipelines") = pipelines,
                  py::arg("fcl_hits") = step.fcl.hits, py::arg("fcl_violations") = step.fcl.violations.size());
}

/// Keeps pipelines and workspaces from step to step.
class Verification {
 public:
  /// `shells`: whether shells are thickened, and contacts between features with copies of the same shell vertex are
  /// left out.
  Verification(const std::vector<std::string>& settings, unsigned threads, double separation, bool fcl,
               bool approximate, Index brute_force_limit, bool shells)
      : verifier_(with_settings(settings), config_of(fcl, approximate, brute_force_limit)),
        executor_(make_signal_executor(threads)),
        separation_(separation),
        leave_out_shell_neighbours_(shells) {}

  py::dict check(Sequence& sequence, int step) {
    const BusyGuard guard(busy_, "verification"), sequence_guard(sequence.busy, "Sequence");
    StepVerdict verdict;
    {
      const py::gil_scoped_release without_gil;
      sequence.go_to(step, *executor_);
      const SequenceStepper& stepper = sequence.stepper();
      verdict = verifier_.check({.topology = stepper.topology(),
                                 .motion = stepper.motion(),
                                 .filter = filter_,
                                 .separation = separation_,
                                 .leave_out_shell_neighbours = leave_out_shell_neighbours_},
                                *executor_);
    }
    return verdict_of(verdict);
  }

  const std::vector<std::string>& skipped() const { return verifier_.skipped_pipelines(); }

 private:
  static Registry with_settings(const std::vector<std::string>& settings) {
    Registry made = registry();
    if (settings.empty()) return made;
    PipelineSpec spec = made.pipeline("VolCCD+", settings);
    for (const std::string& setting : settings) spec.name += " " + setting;
    made.add_pipeline(std::move(spec));
    return made;
  }
  static VerifyConfig config_of(bool fcl, bool approximate, Index brute_force_limit) {
    VerifyConfig config;
    if (!fcl) config.fcl_times.clear();
    config.approximate = approximate;
    config.brute_force_limit = brute_force_limit;
    return config;
  }

  Verifier verifier_;
  std::unique_ptr<Executor> executor_;
  ObjectFilter filter_;
  double separation_;
  bool leave_out_shell_neighbours_;
  bool busy_ = false;
};

}  // namespace

void bind_verify(py::module_& module) {
  py::class_<Verification>(module, "Verification")
      .def(py::init<const std::vector<std::string>&, unsigned, double, bool, bool, Index, bool>())
      .def("check", &Verification::check)
      .def_property_readonly("skipped", &Verification::skipped);
}

}  // namespace volccd::python
