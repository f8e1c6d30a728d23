// Median.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

namespace volccd {

/// As median(), without memory of its own: sorts the values.
inline double sort_to_median(std::span<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
}

/// Median of the values; the mean of the two middle values if their number is even, 0 if there are none.
inline double median(std::vector<double> values) { return sort_to_median(values); }

}  // namespace volccd
