// Progress of long work on a terminal, silence in a pipe; and Ctrl-C as a flag.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace volccd {

/// One line on stderr, rewritten in place with an estimate of the time left; nothing where stderr is not a terminal.
class Progress {
 public:
  Progress(std::string what, std::size_t total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `share`: of the next one, in [0, 1). A share above 0 is shown ten times a second at most.
  void advance(std::size_t done, double share = 0);

 private:
  std::string what_;
  std::size_t total_;
  bool terminal_;
  std::chrono::steady_clock::time_point start_, shown_;
};

/// While it lives, Ctrl-C (SIGINT) and SIGTERM set a flag instead of ending the process: long work looks at it between steps,
/// ends what it is at, writes what is finished, and exits with 130. A second signal ends at once.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  static bool interrupted();
};

}  // namespace volccd
