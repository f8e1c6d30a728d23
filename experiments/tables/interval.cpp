#include <volccd/experiments/tables/interval.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>

#include <volccd/core/median.hpp>
#include <volccd/experiments/tables/catalog.hpp>
#include <volccd/experiments/tables/text_table.hpp>

namespace volccd {

namespace {

constexpr int kResamples = 2000;

struct StepTimes {
  std::vector<double> above, below;  ///< by round
};

/// The steps that both have.
std::vector<StepTimes> common_steps(const Rows& above, const Rows& below, const std::vector<std::string>& columns) {
  std::vector<StepTimes> steps;
  const std::map<int, std::vector<double>> of_below = below.by_round(columns);
  for (const auto& [step, rounds] : above.by_round(columns))
    if (const auto other = of_below.find(step); other != of_below.end()) steps.push_back({rounds, other->second});
  return steps;
}

/// The distributions of the standard library differ from one to another.
class Resampler {
 public:
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(engine_() % n); }

  double median_of(const std::vector<double>& rounds) {
    drawn_.clear();
    for (std::size_t i = 0; i < rounds.size(); ++i) drawn_.push_back(rounds[below(rounds.size())]);
    return sort_to_median(drawn_);
  }

  double ratio(const std::vector<StepTimes>& steps) {
    double above = 0, under = 0;
    for (std::size_t i = 0; i < steps.size(); ++i) {
      const StepTimes& step = steps[below(steps.size())];
      above += median_of(step.above);
      under += median_of(step.below);
    }
    return under > 0 ? above / under : 0;
  }

 private:
  std::mt19937_64 engine_{1};
  std::vector<double> drawn_;
};

}  // namespace

RatioInterval ratio_of_times(const Rows& above, const Rows& below, const std::vector<std::string>& columns) {
  const std::vector<StepTimes> steps = common_steps(above, below, columns);
  double sum_above = 0, sum_below = 0;
  for (const StepTimes& step : steps) {
    sum_above += median(step.above);
    sum_below += median(step.below);
  }
  if (sum_below <= 0) return {};
  Resampler resampler;
  std::vector<double> ratios;
  for (int i = 0; i < kResamples; ++i) ratios.push_back(resampler.ratio(steps));
  std::sort(ratios.begin(), ratios.end());
  const auto at = [&](double share) { return ratios[static_cast<std::size_t>(share * (kResamples - 1))]; };
  return {sum_above / sum_below, at(0.025), at(0.975)};
}

std::string interval_text(const RatioInterval& ratio) {
  if (ratio.value <= 0) return "-";
  if (ratio.high <= ratio.low) return ratio_text(ratio.value);
  const int min_digits = ratio.value < 10 ? 1 : 0;
  const double half = (ratio.high - ratio.low) / 2;
  const int digits = half > 0 ? std::clamp(static_cast<int>(std::ceil(-std::log10(half))), min_digits, 2) : 2;
  return fixed_text(ratio.value, digits) + "x (" + fixed_text(ratio.low, digits) + " to " +
         fixed_text(ratio.high, digits) + ")";
}

}  // namespace volccd
