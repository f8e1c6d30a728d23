// Median.
#pragma once

#include <algorithm>
#include <vector>

namespace volccd {

/// Median of the values; the mean of the two middle values if their number is even, 0 if there are none.
inline double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
}

}  // namespace volccd
