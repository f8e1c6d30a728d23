// The floating-point environment that every bound on rounding errors assumes (docs/numerics.md).
#pragma once

#include <string>

namespace volccd {

/// Describes what is wrong with the floating-point environment of the calling thread: subnormal results or operands are
/// replaced by zero, or rounding is not to nearest. Returns an empty string if nothing is wrong, within a few
/// nanoseconds.
std::string floating_point_problem();

/// Throws ConfigError if floating_point_problem() reports a problem. The message contains the problem and its remedy.
void require_standard_floating_point();

namespace detail {

/// The same as floating_point_problem(), determined by arithmetic operations, so that it works on every processor.
std::string probed_floating_point_problem();

}  // namespace detail

}  // namespace volccd
