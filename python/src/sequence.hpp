// A sequence file with its stepper, for Python.
#pragma once

#include <memory>
#include <string>

#include <volccd/io/sequence/reader.hpp>
#include <volccd/io/sequence/stepper.hpp>

#include "runner.hpp"

namespace volccd::python {

class Sequence {
 public:
  /// Throws InputError, and ConfigError for unknown values of the options (shells, edges, motion, objects).
  Sequence(const std::string& file, const py::dict& options);

  SequenceReader& reader() { return reader_; }
  const SequenceReader& reader() const { return reader_; }
  /// Pre: more than one step.
  SequenceStepper& stepper() { return *stepper_; }
  const SequenceStepper::Config& config() const { return config_; }
  /// The step of the last go_to(), or -1.
  int step() const { return stepper_ ? stepper_->current() : -1; }
  /// Throws InputError if there is no such step. The executor builds the topology in the first call.
  void go_to(int step, Executor& executor);

  bool busy = false;  ///< BusyGuard

 private:
  SequenceReader reader_;
  SequenceStepper::Config config_;
  std::unique_ptr<SequenceStepper> stepper_;
};

/// Runs a pipeline on the steps of sequences.
class SequenceRunner {
 public:
  /// The options of detector_config(). `leave_out_shell_neighbours`: that of RunConfig. Throws ConfigError. The
  /// registry may change afterwards.
  SequenceRunner(const py::dict& options, bool leave_out_shell_neighbours);

  /// Must be called with the GIL, which it releases. Throws the exceptions of Pipeline::run, and those of a signal
  /// handler or of a stage in Python.
  std::shared_ptr<Result> run(Sequence& sequence, int step, const StepRequest& request);
  const StepRunner& runner() const { return runner_; }

 private:
  SequenceRunner(const DetectorConfig& config, bool leave_out_shell_neighbours);

  std::unique_ptr<Executor> executor_;
  StepRunner runner_;
  bool busy_ = false;
};

}  // namespace volccd::python
