// Holds one stage to what it declares: its guarantee and the rules of its interface. For stages of one's own, before
// they are measured: `volccd check`, or check_stage() in a test.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <volccd/pipelines/registry.hpp>

namespace volccd {

struct StageCheckConfig {
  OptionValues options;    ///< of the stage, where they differ from their defaults
  std::uint64_t seed = 1;  ///< trial i has the seed `seed` + i, so that a trial that failed can be repeated by itself
  int trials = 1000;       ///< generated trials; each has up to 64 tests or 8 pairs of elements
  /// Called before each trial of a series, of which there are several; may throw to stop.
  std::function<void(int done, int total)> progress = {};
  unsigned threads = 3;    ///< of the executor that several workers are tried with
  bool pipelines = true;   ///< false: the stage is looked at by itself only
  std::string file;        ///< a sequence whose steps are looked at as well, or empty
  int first_step = 0, end_step = 1 << 30;  ///< motions of the file: first_step <= k < end_step
  /// Number of allocations since some time, of all threads. Null: allocations are not looked at. The program counts
  /// them by itself; a test can hand over a counter of its own operator new.
  std::size_t (*allocation_count)() = nullptr;
};

/// How one promise was kept.
struct PromiseReport {
  std::string promise;        ///< "loses no contact"
  bool required = true;       ///< false: the stage does not give this promise (`approximate`); counted all the same
  std::uint64_t checked = 0;  ///< answers looked at
  std::uint64_t broken = 0;   ///< of those
  std::string example;        ///< the first that broke it: the seed or the step, and the coordinates as literals

  bool kept() const { return !required || broken == 0; }
};

struct StageReport {
  std::string stage, role;
  Guarantee guarantee = Guarantee::approximate;
  std::vector<PromiseReport> promises;

  /// Whether all promises that the stage gives were kept.
  bool kept() const;
};

/// Tries the stage on generated steps: small features with near-degenerate motion, pairs of elements that touch or
/// nearly do, meshes that change, linear and quadratic motion, separations, t_max < 1; then, in pipelines, on colliding
/// bodies and on the steps of the file. What touches is decided in exact arithmetic. A stage is looked at alone and in
/// batches, with several workers, with a new state and with one that has seen other steps. Takes seconds with the
/// default number of trials, half a minute for narrow phases.
///
/// Throws ConfigError for an unknown stage or option, and what SequenceReader throws for the file.
StageReport check_stage(const Registry& registry, const std::string& stage, const StageCheckConfig& config = {});

}  // namespace volccd
