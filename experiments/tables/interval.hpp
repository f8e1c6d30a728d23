// How certain a ratio of times is.
#pragma once

#include <string>
#include <vector>

#include <volccd/experiments/tables/rows.hpp>

namespace volccd {

/// A ratio, and the bounds of its 95 % confidence interval.
struct RatioInterval {
  double value = 0, low = 0, high = 0;
};

/// The mean time of a step in `above` over that in `below`, over the steps that both have; a step's time is its median
/// over rounds. The interval is that of the percentile bootstrap (Efron and Tibshirani 1993, chapter 13) with 2,000
/// resamples: steps are drawn with replacement, the same for both, and of each its rounds for either, so that it covers
/// the choice of steps and the noise of rounds. The same rows give the same interval. All 0 if there is no common step,
/// or `below` took no time.
RatioInterval ratio_of_times(const Rows& above, const Rows& below, const std::vector<std::string>& columns);

/// "7.4x (7.1 to 7.6)", with the digits that the interval leaves certain; without the interval for one round of one
/// step; "-" for a ratio of 0.
std::string interval_text(const RatioInterval& ratio);

}  // namespace volccd
