// Options that several commands share: which steps of a file, which pipeline, how to run it.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include <volccd/core/executor.hpp>
#include <volccd/io/sequence/stepper.hpp>
#include <volccd/pipelines/pipeline.hpp>
#include <volccd/query/object_filter.hpp>

namespace volccd {

/// Steps k with begin <= k < end; step k leads from frame k to frame k+1.
struct StepRange {
  int begin = 0, end = 0;
};

/// "A:B", "A:", ":B", "K" (one step), "" (all), within the steps [0, count) of the file. `unit` is "frame" if frames
/// are counted, with the option --frames; messages name it. Throws InputError if the file has none, ConfigError for
/// another text or range.
StepRange parse_steps(const std::string& text, int count, const std::string& file, std::string_view unit = "step");

/// --threads, within the bound of make_executor(). `purpose` precedes the help text.
void add_threads_option(CLI::App& command, unsigned& threads, const std::string& purpose = "");

/// Options of what is read: --steps, --shells, --edges, --motion; --objects.
struct SequenceOptions {
  std::string file, steps;
  SequenceStepper::Config config;

  void add_to(CLI::App& command);
  void add_objects_to(CLI::App& command);
};

/// What commands print if contacts of shell neighbours are left out.
inline constexpr const char* kShellNeighboursLeftOut =
    "left out: contacts of features that stem from one shell vertex (see --shell-neighbours)";

/// Options of the query: --pairs, --separation, --shell-neighbours, --threads.
struct QueryOptions {
  PairScope pairs = PairScope::all;
  std::string shell_neighbours;
  std::optional<double> separation;
  unsigned threads = 0;

  void add_to(CLI::App& command);
  ObjectFilter filter() const { return ObjectFilter(pairs); }
  /// Whether contacts of shell neighbours are left out (Step): as the option says; by default, for thickened
  /// shells. Throws ConfigError if the option requires it for shells that are not thickened.
  bool leaves_out_shell_neighbours(const SequenceOptions& sequence) const;

  /// The separation of the present step: the one given, else that of the query in query motion, else 0.
  double separation_in(const SequenceStepper& stepper) const { return separation.value_or(stepper.separation()); }
  /// To be called at the first step. Throws ConfigError for a separation greater than the diagonal of the box around
  /// all vertices in use. Warns on stderr if only pairs between objects are requested and there is only one object.
  void check(const SequenceStepper& stepper) const;
};

}  // namespace volccd
