// Makes a set of a vector.
#pragma once

#include <algorithm>
#include <vector>

namespace volccd {

/// Sorts the values and removes repeated ones.
template <class T>
void sort_unique(std::vector<T>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

}  // namespace volccd
