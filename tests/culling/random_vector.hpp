#pragma once

#include <volccd/core/random.hpp>
#include <volccd/numerics/types.hpp>

namespace volccd::detail {

/// Uniform in [-1, 1]^3.
inline Vec3 random_vector(Random& random) {
  return Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
}

}  // namespace volccd::detail
