#include "signals.hpp"

#include <atomic>
#include <chrono>
#include <exception>
#include <string>
#include <thread>
#include <utility>

#include <volccd/core/error.hpp>

namespace volccd::python {

namespace {

constexpr std::chrono::milliseconds kPeriod(50);

/// Thrown by workers after a handler has raised an exception.
struct Stopped {};

class SignalExecutor final : public Executor {
 public:
  explicit SignalExecutor(unsigned threads) : inner_(make_executor(threads)) {}

  unsigned workers() const override { return inner_->workers(); }

  void parallel_for(std::size_t n, std::size_t grain, Body body) override {
    stopped_ = false;
    caller_ = std::this_thread::get_id();
    try {
      look();
      inner_->parallel_for(n, grain, [&](std::size_t begin, std::size_t end, unsigned worker) {
        if (std::this_thread::get_id() == caller_) look();
        if (stopped_.load(std::memory_order_relaxed)) throw Stopped();
        body(begin, end, worker);
      });
    } catch (const Stopped&) {
      std::rethrow_exception(std::exchange(raised_, nullptr));
    }
  }

 private:
  /// Must be called on the calling thread of the library only.
  void look() {
    const auto now = std::chrono::steady_clock::now();
    if (now - looked_ < kPeriod) return;
    looked_ = now;
    try {
      check_signals();
    } catch (const py::error_already_set&) {
      raised_ = std::current_exception();
      stopped_ = true;
      throw Stopped();
    }
  }

  std::unique_ptr<Executor> inner_;
  std::atomic<bool> stopped_{false};
  std::exception_ptr raised_;
  std::thread::id caller_;
  std::chrono::steady_clock::time_point looked_;
};

}  // namespace

std::unique_ptr<Executor> make_signal_executor(unsigned threads) { return std::make_unique<SignalExecutor>(threads); }

void check_signals() {
  const py::gil_scoped_acquire gil;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

BusyGuard::BusyGuard(bool& busy, const char* what) : busy_(busy) {
  if (busy) throw Error(std::string("this ") + what + " is in use by another thread: each thread needs one of its own");
  busy = true;
}

}  // namespace volccd::python
