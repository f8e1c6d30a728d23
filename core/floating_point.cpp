#include <volccd/core/floating_point.hpp>

#include <limits>

#include <fmt/format.h>

#include <volccd/core/error.hpp>

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace volccd {

namespace detail {

std::string probed_floating_point_problem() {
  // Volatile, so that the values are computed at run time, not by the compiler.
  const volatile double min_normal = std::numeric_limits<double>::min();
  const volatile double min = std::numeric_limits<double>::denorm_min();
  const volatile double half = 0.5, large = 0x1p1000, one = 1, tiny = 0x1p-60;
  const volatile double subnormal_result = min_normal * half, of_subnormal = min * large;
  const volatile double above = one + tiny, below = one - tiny;
  if (of_subnormal == 0) return "subnormal operands are taken as zero";  // first: then comparisons are affected, too
  if (subnormal_result == 0) return "subnormal results are flushed to zero";
  if (above != 1 || below != 1) return "results are not rounded to nearest";
  return {};
}

}  // namespace detail

std::string floating_point_problem() {
#if defined(__SSE2__)
  // All arithmetic depends on this register; a probe would take much longer, because operations with subnormals are
  // slow.
  constexpr unsigned kFlushToZero = 0x8000, kDenormalsAreZero = 0x0040, kRounding = 0x6000;
  if ((_mm_getcsr() & (kFlushToZero | kDenormalsAreZero | kRounding)) == 0) return {};
#endif
  return detail::probed_floating_point_problem();
}

void require_standard_floating_point() {
  if (const std::string problem = floating_point_problem(); !problem.empty())
    throw ConfigError(fmt::format(
        "floating point: on this thread {}, with which contacts are lost; restore the default environment, "
        "std::fesetenv(FE_DFL_ENV), in every thread that calls the library before it makes an executor (a program that "
        "is linked with -ffast-math changes it at start-up)",
        problem));
}

}  // namespace volccd
