// Checks that one stage satisfies its declared guarantee and the rules of its interface. For new stages, before they
// are measured: `volccd check`, or check_stage() in a test.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <volccd/pipelines/registry.hpp>

namespace volccd {

struct StageCheckConfig {
  OptionValues options;    ///< of the stage, where they differ from their defaults
  std::uint64_t seed = 1;  ///< trial i has the seed `seed` + i, so that a failed trial can be repeated alone
  int trials = 1000;       ///< generated trials; each has up to 64 tests or 8 pairs of elements
  /// Called before each trial of a series, of which there are several; may throw to stop.
  std::function<void(int done, int total)> progress = {};
  unsigned threads = 3;  ///< of the executor used to check runs with several workers
  /// The trials use all instruction sets that the vector kernels are compiled for and that the processor has, in turn:
  /// for the whole process, so that nothing else may run the stages or another check at the same time. false: the best.
  bool instruction_sets = true;
  bool pipelines = true;  ///< false: the stage is not checked in pipelines
  /// Passes further steps to `use`, such as those of a file, with a text that names each. The stage is run on them in
  /// pipelines.
  std::function<void(const std::function<void(const Step& step, const std::string& where)>& use)> further_steps = {};
  /// Number of allocations so far, of all threads. Null: allocations are not checked. The program counts them itself; a
  /// test can pass a counter of its own operator new.
  std::size_t (*allocation_count)() = nullptr;
};

/// The result for one promise (a property that is checked).
struct PromiseReport {
  std::string promise;        ///< "loses no contact"
  bool required = true;       ///< false: the stage does not promise this (`approximate`); it is counted only
  std::uint64_t checked = 0;  ///< number of answers checked
  std::uint64_t broken = 0;   ///< number of those that broke the promise
  std::string example;        ///< the first such answer: seed or step, and coordinates as literals

  bool kept() const { return !required || broken == 0; }
};

struct StageReport {
  std::string stage, role;
  Guarantee guarantee = Guarantee::approximate;
  std::vector<PromiseReport> promises;

  /// Whether all promises that the stage gives were kept.
  bool kept() const;
};

/// Runs the stage on generated steps: small features with near-degenerate motion, pairs of elements that touch or
/// nearly touch, meshes that change, linear and quadratic motion, separations, and t_max < 1, with each instruction set
/// of the processor; then, in pipelines, on colliding bodies, floods and orphan sources also on meshes made to break
/// them (cases::make_hostile), and on the further steps. Exact arithmetic decides which features touch. A stage is
/// checked on single items and on batches, with several workers, with a new state and with one that was used for other
/// steps. Takes seconds with the default number of trials, half a minute for narrow phases.
///
/// Throws ConfigError for an unknown stage or option, and what further_steps() throws.
StageReport check_stage(const Registry& registry, const std::string& stage, const StageCheckConfig& config = {});

}  // namespace volccd
