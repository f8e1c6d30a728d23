// The features of an element that a mask does not exclude.
#pragma once

#include <cstddef>
#include <span>

#include <volccd/mesh/types.hpp>

namespace volccd::detail {

/// Calls visit(feature) for each feature whose bit in `mask` is not set. Features beyond the number of bits are always
/// visited (FeatureMask).
template <class Mask, class Visit>
void for_each_unmasked(std::span<const Index> features, Mask mask, Visit&& visit) {
  constexpr std::size_t bits = 8 * sizeof(Mask);
  for (std::size_t i = 0; i < features.size(); ++i)
    if (i >= bits || (mask >> i & 1) == 0) visit(features[i]);
}

}  // namespace volccd::detail
