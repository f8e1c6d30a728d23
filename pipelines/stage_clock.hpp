// Measures the time that a worker spends in each stage.
#pragma once

#include <chrono>

namespace volccd {

/// A stopwatch that adds elapsed time to one account (a number of seconds) at a time. Not thread-safe.
class StageClock {
 public:
  /// Whether time is currently added to an account.
  bool running() const { return account_ != nullptr; }

 private:
  friend class StageTimer;

  void switch_to(double* account) {
    if (account == account_) return;  // avoids reading the clock
    const auto now = std::chrono::steady_clock::now();
    if (account_) *account_ += std::chrono::duration<double>(now - since_).count();
    account_ = account;
    since_ = now;
  }

  double* account_ = nullptr;
  std::chrono::steady_clock::time_point since_;
};

/// During its lifetime, elapsed time is added to `seconds` instead of the previous account; its destructor switches
/// back to that account. If constructed without `seconds`, the time is added to no account.
class StageTimer {
 public:
  StageTimer(StageClock& clock, double& seconds) : StageTimer(clock, &seconds) {}
  explicit StageTimer(StageClock& clock) : StageTimer(clock, nullptr) {}
  ~StageTimer() { clock_.switch_to(outer_); }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  StageTimer(StageClock& clock, double* account) : clock_(clock), outer_(clock.account_) { clock.switch_to(account); }

  StageClock& clock_;
  double* const outer_;
};

}  // namespace volccd
