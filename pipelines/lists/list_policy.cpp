#include <volccd/pipelines/lists/list_policy.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace volccd {

std::optional<ListPolicy::Plan> ListPolicy::plan(const Motion& motion) {
  if (!has_credit() || fresh_ == 0 || !std::isfinite(motion.distance)) return std::nullopt;
  const double max_travel = max_travel_ * motion.edge, length = std::max(motion.length, 1e-12 * motion.edge);
  double steps = std::min(max_travel / length, kMaxSteps * motion.steps), budget = 0;
  // Further than it was observed, the distance grows as with a constant acceleration.
  const double observed = motion.steps * (motion.steps + 1);
  for (; steps >= kMinSteps; steps *= 0.8) {
    budget = ratio_ * steps * length + motion.distance * std::max(1.0, steps * (steps + 1) / observed);
    if (budget <= max_budget() * motion.edge) break;
  }
  if (!(steps >= kMinSteps)) return std::nullopt;
  planned_steps_ = std::floor(steps);
  planned_budget_ = budget;
  return Plan{planned_steps_, planned_budget_};
}

void ListPolicy::record_fresh(double seconds) {
  if (++fresh_steps_ == 1) return;
  fresh_ = fresh_ == 0 ? seconds : 0.5 * (fresh_ + seconds);
  cost_ *= std::pow(kFirstCost / cost_, kForgotten);
  max_travel_ *= std::pow(kFirstTravel / max_travel_, kForgotten);
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

void ListPolicy::record_use(double seconds, double in_vain) {
  ++uses_;
  used_ += seconds;
  wasted_ += in_vain;
  credit_ = std::min(credit_ + 1 - seconds / fresh_, kMaxCredit);
}

/// Single times are too uncertain to give up a list for them.
bool ListPolicy::is_worthwhile() const { return used_ < (uses_ < 4 ? 2 : 0.95) * uses_ * fresh_; }

void ListPolicy::record_end(double covered, double missed, double seconds) {
  credit_ -= seconds / fresh_;
  const bool early = missed > 0 && uses_ < planned_steps_ / 2;
  if (early && missed < 4 * planned_budget_) ratio_ = std::min(2 * ratio_, 0.5);
  if (missed == 0 && covered < planned_budget_ / 4) ratio_ = std::max(ratio_ / 2, 1.0 / 256);
  // Each max_travel_ is compared with the one before it. It is too great where tests in vain take longer than the list.
  const double price = (build_ + wasted_) / uses_;
  if (price > std::exchange(price_, price)) change_ = 1 / change_;
  if (!is_worthwhile() || wasted_ > build_) change_ = std::min(change_, 1 / change_);
  max_travel_ = std::clamp(max_travel_ * change_, 1.0 / 64, 4.0);
}

}  // namespace volccd
