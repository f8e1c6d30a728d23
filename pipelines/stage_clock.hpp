// Whom a worker's time is charged to.
#pragma once

#include <chrono>

namespace volccd {

/// A stop watch that charges time to one account at a time. One thread at a time.
class StageClock {
 public:
  /// Whether some account is being charged.
  bool running() const { return account_ != nullptr; }

 private:
  friend class StageTimer;

  void switch_to(double* account) {
    if (account == account_) return;  // saves reading the clock
    const auto now = std::chrono::steady_clock::now();
    if (account_) *account_ += std::chrono::duration<double>(now - since_).count();
    account_ = account;
    since_ = now;
  }

  double* account_ = nullptr;
  std::chrono::steady_clock::time_point since_;
};

/// While it lives, time is added to `seconds` and not to what was charged before; afterwards that goes on. Without an
/// account, time is charged to nobody.
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
