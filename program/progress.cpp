#include <volccd/program/progress.hpp>

#include <unistd.h>

#include <csignal>
#include <cstdio>

#include <fmt/format.h>

#include <volccd/experiments/tables/text_table.hpp>

namespace volccd {

namespace {
/// Minimum time between two updates within one unit of work.
constexpr std::chrono::milliseconds kShortest(100);

bool silent = false;
/// Above this number of units, not every unit causes an update.
constexpr std::size_t kMany = 200;

volatile std::sig_atomic_t interrupt_flag = 0;
int guards = 0;  ///< that live; made and destroyed on the main thread

void on_signal(int signal) {
  if (interrupt_flag) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
  interrupt_flag = 1;
}

class InterruptibleExecutor final : public Executor {
 public:
  explicit InterruptibleExecutor(std::unique_ptr<Executor> inner) : inner_(std::move(inner)) {}

  unsigned workers() const override { return inner_->workers(); }

  void parallel_for(std::size_t n, std::size_t grain, Body body) override {
    InterruptGuard::check();
    inner_->parallel_for(n, grain, [&](std::size_t begin, std::size_t end, unsigned worker) {
      InterruptGuard::check();
      body(begin, end, worker);
    });
    InterruptGuard::check();
  }

 private:
  std::unique_ptr<Executor> inner_;
};
}  // namespace

void Progress::silence() { silent = true; }

Progress::Progress(std::string what, std::size_t total, std::string units)
    : what_(std::move(what)),
      units_(std::move(units)),
      total_(total),
      terminal_(!silent && isatty(STDERR_FILENO) == 1),
      start_(std::chrono::steady_clock::now()) {
  advance(0);
}

Progress::~Progress() {
  if (terminal_) fmt::print(stderr, "\r\033[K");
}

void Progress::advance(std::size_t done, double share) {
  if (!terminal_) return;
  const auto now = std::chrono::steady_clock::now();
  if ((share > 0 || total_ > kMany) && now - shown_ < kShortest) return;
  shown_ = now;
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const double all_done = static_cast<double>(done) + share;
  std::string more;
  if (share > 0) more = fmt::format(", {:.0f} % of the next", 100 * share);
  // An estimate from less than one complete unit would be inaccurate.
  if (done > 0 && done < total_)
    more += ", " + duration(elapsed / all_done * (static_cast<double>(total_) - all_done)) + " left";
  fmt::print(stderr, "\r\033[K{}: {} of {} {}{}", what_, done, total_, units_, more);
  std::fflush(stderr);
}

InterruptGuard::InterruptGuard() {
  if (guards++ > 0) return;
  interrupt_flag = 0;
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
}

InterruptGuard::~InterruptGuard() {
  if (--guards > 0) return;
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

bool InterruptGuard::interrupted() { return interrupt_flag != 0; }

void InterruptGuard::check() {
  if (interrupted()) throw Interrupted(kStoppedByUser);
}

std::unique_ptr<Executor> make_interruptible_executor(unsigned threads) {
  return std::make_unique<InterruptibleExecutor>(make_executor(threads));
}

}  // namespace volccd
