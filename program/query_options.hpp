// Options that several commands share: which steps of a file, which pipeline, how to run it.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <volccd/core/executor.hpp>
#include <volccd/io/sequence/stepper.hpp>
#include <volccd/pipelines/pipeline.hpp>
#include <volccd/query/object_filter.hpp>

namespace volccd {

/// Motions k -> k+1 with begin <= k < end.
struct StepRange {
  int begin = 0, end = 0;
};

/// "A:B", "A:", ":B", "K" (one motion), "" (all), within the motions [0, motions) of the file. Throws InputError.
StepRange parse_steps(const std::string& text, int motions, const std::string& file);

/// --threads, within the bound of make_executor(). `purpose` precedes the help text.
void add_threads_option(CLI::App& command, unsigned& threads, const std::string& purpose = "");

/// Options of what is read: --steps, --shells, --edges, --motion; --parts.
struct SequenceOptions {
  std::string file, steps, shells = "surface", edges = "triangulated", motion = "linear", parts = "stored";

  void add_to(CLI::App& command);
  void add_parts_to(CLI::App& command);
  SequenceStepper::Config stepper() const;
};

/// Options of the query: --pairs, --separation, --shell-neighbours, --threads.
struct QueryOptions {
  std::string pairs = "all", shell_neighbours;
  std::optional<double> separation;
  unsigned threads = 0;

  void add_to(CLI::App& command);
  ObjectFilter filter() const;
  /// Whether contacts of shell neighbours are left out (Request): as the option says; by default, for thickened
  /// shells. Throws ConfigError if the option requires it for shells that are not thickened.
  bool leaves_out_shell_neighbours(const SequenceOptions& sequence) const;

  /// The separation of the present motion: the one given, else that of the query in query motion, else 0.
  double separation_in(const SequenceStepper& stepper) const { return separation.value_or(stepper.separation()); }
  /// To be called at the first motion. Throws ConfigError for a separation greater than the diagonal of the box around
  /// all vertices in use. Warns on stderr if only pairs between parts are requested and there is only one part.
  void check(const SequenceStepper& stepper) const;
};

}  // namespace volccd
