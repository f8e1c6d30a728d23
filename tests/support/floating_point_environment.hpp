// Floating-point environments that a host program may leave behind.
#pragma once

#include <cfenv>
#include <string>
#include <utility>
#include <vector>

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace volccd::test {

enum class Change { flush_results, flush_operands, upward, downward, toward_zero };

/// Changes that this processor supports, each with a part of the library's message.
inline std::vector<std::pair<Change, std::string>> environments() {
  std::vector<std::pair<Change, std::string>> all = {
      {Change::upward, "nearest"}, {Change::downward, "nearest"}, {Change::toward_zero, "nearest"}};
#if defined(__SSE2__)
  all.push_back({Change::flush_results, "subnormal results"});
  all.push_back({Change::flush_operands, "subnormal operands"});
#endif
  return all;
}

/// Changes the environment of the calling thread while this object exists.
class ChangedEnvironment {
 public:
  explicit ChangedEnvironment(Change change) {
    std::fegetenv(&before_);
    switch (change) {
      case Change::upward: std::fesetround(FE_UPWARD); break;
      case Change::downward: std::fesetround(FE_DOWNWARD); break;
      case Change::toward_zero: std::fesetround(FE_TOWARDZERO); break;
      case Change::flush_results:
      case Change::flush_operands:
#if defined(__SSE2__)
        _mm_setcsr(_mm_getcsr() | (change == Change::flush_results ? 0x8000u : 0x0040u));
#endif
        break;
    }
  }
  ~ChangedEnvironment() { std::fesetenv(&before_); }
  ChangedEnvironment(const ChangedEnvironment&) = delete;
  ChangedEnvironment& operator=(const ChangedEnvironment&) = delete;

 private:
  std::fenv_t before_;
};

}  // namespace volccd::test
