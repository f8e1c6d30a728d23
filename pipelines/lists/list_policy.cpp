#include <volccd/pipelines/lists/list_policy.hpp>

#include <algorithm>
#include <cmath>

namespace volccd {

std::optional<ListPolicy::Plan> ListPolicy::plan(const Motion& motion) {
  if (!has_credit() || fresh_ == 0 || !std::isfinite(motion.distance)) return std::nullopt;
  const double reach = reach_ * motion.edge, way = std::max(motion.length, 1e-12 * motion.edge);
  double steps = std::min(reach / way, kMaxSteps), budget = 0;
  // With a constant acceleration, the distance from the prediction grows with the square of the number of steps.
  for (; steps >= kMinSteps; steps *= 0.8) {
    budget = ratio_ * steps * way + motion.distance * steps * steps / 2;
    if (budget <= reach / 4) break;
  }
  if (!(steps >= kMinSteps)) return std::nullopt;
  planned_steps_ = std::floor(steps);
  planned_budget_ = budget;
  return Plan{planned_steps_, planned_budget_};
}

void ListPolicy::record_fresh(double seconds) {
  if (++fresh_steps_ == 1) return;
  fresh_ = fresh_ == 0 ? seconds : 0.5 * (fresh_ + seconds);
  credit_ = std::min(credit_ + kShare, kMaxCredit);
}

void ListPolicy::record_list(double build) {
  build_ = build;
  cost_ = build / fresh_;
  credit_ -= cost_;
  wasted_ = 0;
  used_ = 0;
  uses_ = 0;
}

void ListPolicy::record_use(double seconds, double waste) {
  ++uses_;
  used_ += seconds;
  wasted_ += waste * seconds;
  credit_ = std::min(credit_ + 1 - seconds / fresh_, kMaxCredit);
}

/// Single times are too uncertain to give up a list for them.
bool ListPolicy::is_worthwhile() const { return used_ < (uses_ < 4 ? 2 : 0.95) * uses_ * fresh_; }

void ListPolicy::record_end(double covered, double missed, double seconds) {
  credit_ -= seconds / fresh_;
  const bool early = missed > 0 && uses_ < planned_steps_ / 2;
  if (early && missed < 4 * planned_budget_) ratio_ = std::min(2 * ratio_, 0.5);
  if (missed == 0 && covered < planned_budget_ / 4) ratio_ = std::max(ratio_ / 2, 1.0 / 256);
  // The time of a step is least where making lists costs as much as tests in vain.
  if (!is_worthwhile() || wasted_ > 2 * build_) reach_ = std::max(reach_ / 1.5, 1.0 / 64);
  if (is_worthwhile() && missed == 0 && build_ > 2 * wasted_) reach_ = std::min(reach_ * 1.5, 4.0);
}

}  // namespace volccd
