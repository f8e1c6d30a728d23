#include <volccd/experiments/program/progress.hpp>

#include <unistd.h>

#include <csignal>
#include <cstdio>

#include <fmt/format.h>

#include <volccd/experiments/tables/text_table.hpp>

namespace volccd {

namespace {
volatile std::sig_atomic_t interrupt_flag = 0;

void on_signal(int signal) {
  if (interrupt_flag) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
  interrupt_flag = 1;
}
}  // namespace

Progress::Progress(std::string what, std::size_t total)
    : what_(std::move(what)),
      total_(total),
      terminal_(isatty(STDERR_FILENO) == 1),
      start_(std::chrono::steady_clock::now()) {
  advance(0);
}

Progress::~Progress() {
  if (terminal_) fmt::print(stderr, "\r\033[K");
}

void Progress::advance(std::size_t done) {
  if (!terminal_) return;
  const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  std::string left;
  if (done > 0 && done < total_)
    left = ", " + duration(elapsed / static_cast<double>(done) * static_cast<double>(total_ - done)) + " left";
  fmt::print(stderr, "\r\033[K{} {}/{}{}", what_, done, total_, left);
  std::fflush(stderr);
}

InterruptGuard::InterruptGuard() {
  interrupt_flag = 0;
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
}

InterruptGuard::~InterruptGuard() {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

bool InterruptGuard::interrupted() { return interrupt_flag != 0; }

}  // namespace volccd
