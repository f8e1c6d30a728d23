// Times at which a polynomial vanishes, as exact numbers.
#pragma once

#include <memory>
#include <vector>

#include <volccd/narrowphase/detail/integer_polynomial.hpp>

namespace volccd::detail {

/// A real algebraic number in [0,1]: a dyadic number, or the only root of a polynomial within an open interval with
/// dyadic ends. Questions about it may shorten the interval, hence are not const.
class AlgebraicTime {
 public:
  explicit AlgebraicTime(Dyadic t) : lo_(t.numerator), hi_(std::move(t.numerator)), bits_(t.bits) {}
  /// The root of *p in (index, index + 1) / 2^bits. Pre: there is one, and no other; it is simple.
  AlgebraicTime(std::shared_ptr<const Polynomial> p, const Integer& index, unsigned bits);

  /// Sign of g at this time; zero is decided by the greatest common divisor.
  int sign(const Polynomial& g);
  /// Sign of (this - t).
  int compare(const Dyadic& t);
  /// The largest double that is at most this time.
  double floor();
  /// Whether it is known to be a dyadic number. True after floor() if that is the time itself.
  bool exact() const { return lo_ == hi_; }

  /// Sign of f just before and just after this time. Pre: f has no root in the interval but this one, of any
  /// multiplicity.
  int sign_before(const Polynomial& f) const;
  int sign_after(const Polynomial& f) const;

 private:
  /// Near the time, as rounding has it; not negative.
  double guess() const;
  void bisect();
  bool is_root_of(const Polynomial& g) const;
  /// Makes ends a multiple of 2^-bits.
  void express_in(unsigned bits);

  std::shared_ptr<const Polynomial> p_;
  Integer lo_, hi_;  ///< over 2^bits_; equal for a dyadic number
  unsigned bits_;
  int before_ = 0;  ///< sign of *p_ between lo and the root
};

/// All roots of p in (0,1], each once, ascending: bisection by Descartes' rule of signs (Collins and Akritas 1976), on
/// the square-free part where that is needed. Pre: p is not zero.
std::vector<AlgebraicTime> roots_in_step(const Polynomial& p);

}  // namespace volccd::detail
