// The earliest of several exact times.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <volccd/narrowphase/exact/detail/algebraic_time.hpp>
#include <volccd/narrowphase/exact/exact_predicates.hpp>

namespace volccd::detail {

/// Collects times of contact in [0, t_max] and keeps the earliest as a double (ExactAnswer).
class FirstTime {
 public:
  explicit FirstTime(double t_max) : t_max_(t_max) {}

  /// The first of the roots of p in (0, t_max] for which the predicate is true. Times that as doubles are later than
  /// the one that is known are not examined. Pre: p is not zero.
  template <class Predicate>
  std::optional<AlgebraicTime> first_root(const Polynomial& p, Predicate&& predicate) const {
    const double latest = answer.touches ? std::min(t_max_, std::nextafter(answer.toi, 1.0)) : t_max_;
    for (AlgebraicTime& t : roots_in_step(p)) {
      if (t.compare(dyadic(latest)) > 0) break;
      if (predicate(t)) return std::move(t);
    }
    return std::nullopt;
  }

  /// Among times with the same largest double below, a time that is equal to this double is the earliest.
  void keep_earlier(AlgebraicTime& t, TouchCase reason) {
    const double toi = t.floor();
    // A time of the form n / 2^k is known exactly, and may nevertheless have too many bits for a double.
    const bool exact = t.compare(dyadic(toi)) == 0;
    if (answer.touches && (answer.toi < toi || (answer.toi == toi && answer.toi_exact))) return;
    answer.touches = true;
    answer.toi = toi;
    answer.toi_exact = exact;
    answer.reason = reason;
  }

  void keep_start() {
    answer.touches = answer.toi_exact = true;
    answer.toi = 0;
    answer.reason = TouchCase::at_start;
  }

  ExactAnswer answer;

 private:
  double t_max_;
};

}  // namespace volccd::detail
