// Progress of long work, shown on a terminal only; and Ctrl-C, which stops the work and keeps complete results.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>

#include <volccd/core/error.hpp>
#include <volccd/core/executor.hpp>

namespace volccd {

/// One line on stderr that is overwritten: "detecting: 3 of 8 steps, 40 % of the next, 12.0 s left". Nothing is printed
/// if stderr is not a terminal. Every command that can take more than a second has one.
class Progress {
 public:
  /// `units`: what is counted, in the plural.
  Progress(std::string what, std::size_t total, std::string units = "steps");
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `share`: the completed fraction of the next unit, in [0, 1). Fractions, and units if there are many, are shown at
  /// most ten times a second.
  void advance(std::size_t done, double share = 0);

  /// Disables the progress of this process (--quiet). Must be called before other threads are started.
  static void silence();

 private:
  std::string what_, units_;
  std::size_t total_;
  bool terminal_;
  std::chrono::steady_clock::time_point start_, shown_;
};

/// Thrown when the user has stopped the work; complete results are kept. Exit code 130.
class Interrupted : public Error {
 public:
  using Error::Error;
};

/// The reason in an incomplete record if the user has stopped the run.
inline constexpr const char* kStoppedByUser = "interrupted";

/// While a guard exists, Ctrl-C (SIGINT) and SIGTERM set a flag and do not end the process. Long work checks the flag,
/// discards its present step, writes the complete results, and exits with 130. A second signal ends the process at
/// once. Guards may be nested.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  static bool interrupted();
  /// Throws Interrupted if so.
  static void check();
};

/// make_executor() for work under an InterruptGuard: after Ctrl-C no further chunk is begun, and parallel_for throws
/// Interrupted. Incomplete results must then be discarded.
std::unique_ptr<Executor> make_interruptible_executor(unsigned threads);

}  // namespace volccd
