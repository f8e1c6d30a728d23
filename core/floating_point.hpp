// The floating-point environment that every bound on rounding errors assumes (docs/numerics.md).
#pragma once

#include <string>

namespace volccd {

/// What is wrong with the calling thread's floating-point environment, empty if nothing is: subnormal results or
/// operands are replaced by zero, or rounding is not to nearest. A few nanoseconds where nothing is wrong.
std::string floating_point_problem();

/// Throws ConfigError with that problem and what to do about it.
void require_standard_floating_point();

namespace detail {

/// The same, found by arithmetic on any processor.
std::string probed_floating_point_problem();

}  // namespace detail

}  // namespace volccd
