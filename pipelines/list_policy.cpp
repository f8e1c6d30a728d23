#include <volccd/pipelines/list_policy.hpp>

#include <algorithm>
#include <cmath>

namespace volccd {

std::optional<ListPolicy::Plan> ListPolicy::plan(const Motion& motion) {
  if (fresh_ == 0 || !std::isfinite(motion.distance) || cost_ - 1 > credit_) return std::nullopt;
  const double way = std::max(motion.length, 1e-12 * motion.edge);
  const double steps = std::min(std::floor(reach_ * motion.edge / way), kMaxSteps);
  const double budget = ratio_ * steps * way;
  // With a constant acceleration, the distance from the prediction grows with the square of the number of steps.
  const double covered = motion.distance > 0 ? std::min(steps, std::sqrt(2 * budget / motion.distance)) : steps;
  if (!(covered >= kMinSteps)) return std::nullopt;
  planned_steps_ = steps;
  planned_budget_ = budget;
  return Plan{steps, budget};
}

void ListPolicy::record_fresh(double seconds) {
  fresh_ = fresh_ == 0 ? seconds : std::min(seconds, 0.5 * (fresh_ + seconds));  // first steps take long
  credit_ = std::min(credit_ + kShare, kMaxCredit);
}

/// The difference to a fresh step.
void ListPolicy::pay(double seconds) {
  spent_ += seconds;
  ++used_;
  credit_ = std::min(credit_ + 1 - seconds / fresh_, kMaxCredit);
}

void ListPolicy::record_list(double build, double seconds) {
  cost_ = build / fresh_;
  spent_ = 0;
  used_ = 0;
  pay(build + seconds);
}

void ListPolicy::record_reuse(double seconds) { pay(seconds); }

void ListPolicy::record_end(bool by_budget, double distance) {
  if (used_ == 0) return;
  if (by_budget && used_ < planned_steps_ / 2) ratio_ = std::min(2 * ratio_, 1.0);
  if (!by_budget && distance < planned_budget_ / 4) ratio_ = std::max(ratio_ / 2, 1.0 / 128);
  // The reach goes on in the direction in which the mean time of a step falls.
  const double mean = spent_ / used_ / fresh_;
  if (last_mean_ > 0 && mean > 1.02 * last_mean_) trend_ = 1 / trend_;
  last_mean_ = mean;
  if (!by_budget) reach_ = std::clamp(trend_ * reach_, 1.0 / 64, 16.0);
  used_ = 0;
}

}  // namespace volccd
