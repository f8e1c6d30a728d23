// Handles Ctrl-C while the library works.
#pragma once

#include <memory>

#include <volccd/core/executor.hpp>

#include "bind.hpp"

namespace volccd::python {

/// make_executor() for work without the GIL: the calling thread looks for signals every 50 ms, between chunks. If a
/// handler raises (KeyboardInterrupt), no further chunk is begun, and parallel_for throws that exception. Signals are
/// handled by Python's main thread only, as elsewhere.
std::unique_ptr<Executor> make_signal_executor(unsigned threads);

/// For loops without an executor, with or without the GIL: throws the exception that a handler raised.
void check_signals();

/// Throws Error if the caller already holds it, because objects with a workspace serve one thread at a time.
class BusyGuard {
 public:
  BusyGuard(bool& busy, const char* what);
  ~BusyGuard() { busy_ = false; }
  BusyGuard(const BusyGuard&) = delete;
  BusyGuard& operator=(const BusyGuard&) = delete;

 private:
  bool& busy_;  ///< read and written with the GIL held
};

}  // namespace volccd::python
