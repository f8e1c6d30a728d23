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

  void advance(std::size_t done);

 private:
  std::string what_;
  std::size_t total_;
  bool terminal_;
  std::chrono::steady_clock::time_point start_;
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
