#include <volccd/mesh/detail/incidences.hpp>

#include <algorithm>
#include <array>

namespace volccd::detail {

void Incidences::sort() {
  sort_pairs();
  elements_.reserve(pairs_.size());
  for (const Pair& pair : pairs_) elements_.push_back(pair.element);
}

void Incidences::sort_pairs() {
  constexpr std::size_t kFew = 256;  // below this number sorting by comparisons is faster than counting
  constexpr unsigned kBits = 11, kDigits = 1u << kBits;
  if (pairs_.size() < kFew) {
    std::sort(pairs_.begin(), pairs_.end(), [](const Pair& x, const Pair& y) {
      return x.feature != y.feature ? x.feature < y.feature : x.element < y.element;
    });
    return;
  }
  // Radix sort by feature. It is stable, and elements are already ascending.
  Index max = 0;
  for (const Pair& pair : pairs_) max = std::max(max, pair.feature);
  std::vector<Pair> scratch(pairs_.size());
  for (unsigned shift = 0; shift < 32 && max >> shift != 0; shift += kBits) {
    std::array<std::size_t, kDigits + 1> begin{};
    const auto digit = [&](const Pair& pair) { return (pair.feature >> shift) % kDigits; };
    for (const Pair& pair : pairs_) ++begin[digit(pair) + 1];
    for (std::size_t d = 0; d < kDigits; ++d) begin[d + 1] += begin[d];
    for (const Pair& pair : pairs_) scratch[begin[digit(pair)]++] = pair;
    pairs_.swap(scratch);
  }
}

}  // namespace volccd::detail
