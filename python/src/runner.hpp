// The arguments and the results of detections for Python.
#pragma once

#include <memory>
#include <string>

#include <volccd/pipelines/detector.hpp>

#include "result.hpp"

namespace volccd::python {

/// The arguments of a Detector in Python except for its mesh, from a dict with the keys pipeline, settings, threads,
/// separation, pairs, exclude, all of which must be present. Throws ConfigError.
DetectorConfig detector_config(const py::dict& options);

/// The options of a step.
struct StepRequest {
  bool first = false, initial_overlaps = false;
  double t_max = 1;
  bool ends = false;

  Request request() const {
    return {.query = first ? Query::first : Query::all, .initial_overlaps = initial_overlaps, .ends = ends};
  }
};

/// The last result of a Detector or StepRunner, moved out.
template <class Runner>
std::shared_ptr<Result> make_result(Runner& runner) {
  return std::make_shared<Result>(runner.release_result());
}

/// Properties of a Detector or StepRunner for Python: pipeline, guarantee, threads, stages.
py::dict facts_of(const Pipeline& pipeline, const Executor& executor);

}  // namespace volccd::python
