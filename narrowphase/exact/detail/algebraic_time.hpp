// Times at which a polynomial vanishes, represented exactly.
#pragma once

#include <memory>
#include <vector>

#include <volccd/narrowphase/exact/detail/integer_polynomial.hpp>

namespace volccd::detail {

/// A real algebraic number in [0,1]: a dyadic number, or the only root of a polynomial in an open interval with dyadic
/// ends. Members that compare it may shorten the interval and therefore are not const.
class AlgebraicTime {
 public:
  explicit AlgebraicTime(Dyadic t) : lo_(t.numerator), hi_(std::move(t.numerator)), bits_(t.bits) {}
  /// The root of *p in (index, index + 1) / 2^bits. Pre: the interval contains exactly one root, which is simple.
  AlgebraicTime(std::shared_ptr<const Polynomial> p, const Integer& index, unsigned bits);

  /// Sign of g at this time. The greatest common divisor decides whether it is zero.
  int sign(const Polynomial& g);
  /// Sign of (this - t).
  int compare(const Dyadic& t);
  /// The largest double that is not greater than this time.
  double floor();
  /// Whether this is known to be a dyadic number. After floor(), true if its result is equal to this time.
  bool exact() const { return lo_ == hi_; }

  /// Sign of f just before and just after this time. Pre: this time is the only root of f in the interval, of any
  /// multiplicity.
  int sign_before(const Polynomial& f) const;
  int sign_after(const Polynomial& f) const;

 private:
  /// An approximation of the time in rounded arithmetic; not negative.
  double guess() const;
  void bisect();
  bool is_root_of(const Polynomial& g) const;
  /// Changes the denominator of the ends to 2^bits.
  void express_in(unsigned bits);

  std::shared_ptr<const Polynomial> p_;
  Integer lo_, hi_;  ///< numerators over 2^bits_; equal for a dyadic number
  unsigned bits_;
  int before_ = 0;  ///< sign of *p_ between lo and the root
};

/// All roots of p in (0,1], each once, in ascending order: bisection by Descartes' rule of signs (Collins and Akritas
/// 1976), applied to the square-free part if necessary. Pre: p is not zero.
std::vector<AlgebraicTime> roots_in_step(const Polynomial& p);

}  // namespace volccd::detail
