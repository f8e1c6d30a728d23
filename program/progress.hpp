// Progress of long work on a terminal, silence in a pipe; and Ctrl-C, which stops work and keeps what is complete.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>

#include <volccd/core/error.hpp>
#include <volccd/core/executor.hpp>

namespace volccd {

/// One line on stderr, rewritten in place: "detecting: 3 of 8 steps, 40 % of the next, 12.0 s left"; nothing where
/// stderr is not a terminal. Every command that can take more than a second has one.
class Progress {
 public:
  /// `units`: what is counted, in the plural.
  Progress(std::string what, std::size_t total, std::string units = "steps");
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `share`: of the next one, in [0, 1). A share above 0, and those of many, are shown ten times a
  /// second at most.
  void advance(std::size_t done, double share = 0);

  /// No progress of this process from now on (--quiet). To be called before there are other threads.
  static void silence();

 private:
  std::string what_, units_;
  std::size_t total_;
  bool terminal_;
  std::chrono::steady_clock::time_point start_, shown_;
};

/// The user stopped the work; what is complete is kept. Exit code 130.
class Interrupted : public Error {
 public:
  using Error::Error;
};

/// How a record that ends early says that it was the user.
inline constexpr const char* kStoppedByUser = "interrupted";

/// While one lives, Ctrl-C (SIGINT) and SIGTERM set a flag instead of ending the process: long work looks at it,
/// abandons the step it is at, writes what is complete, and exits with 130. A second signal ends at once. Guards may be
/// nested.
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
/// Interrupted. What the work has left half done must then be thrown away.
std::unique_ptr<Executor> make_interruptible_executor(unsigned threads);

}  // namespace volccd
