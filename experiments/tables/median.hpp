// The middle of some values.
#pragma once

#include <algorithm>
#include <vector>

namespace volccd {

/// 0 if there are none; of an even number the mean of the two in the middle.
inline double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
}

}  // namespace volccd
