// Polynomials in t with integer coefficients of arbitrary size.
#pragma once

#include <vector>

#ifdef VOLCCD_WITHOUT_GMP
#include <boost/multiprecision/cpp_int.hpp>
#else
#include <boost/multiprecision/gmp.hpp>
#endif

namespace volccd::detail {

#ifdef VOLCCD_WITHOUT_GMP
using Integer = boost::multiprecision::cpp_int;
using Rational = boost::multiprecision::cpp_rational;
#else
using Integer = boost::multiprecision::mpz_int;
using Rational = boost::multiprecision::mpq_rational;
#endif

inline int sign_of(const Integer& x) { return x.sign(); }

/// The number numerator / 2^bits.
struct Dyadic {
  Integer numerator;
  unsigned bits;
};

/// Exact conversion. Pre: x is finite.
Dyadic dyadic(double x);

/// c[0] + c[1] t + ...; the last coefficient is not zero. The zero polynomial has no coefficients.
class Polynomial {
 public:
  Polynomial() = default;
  explicit Polynomial(std::vector<Integer> coefficients);

  bool is_zero() const { return c_.empty(); }
  /// Degree; -1 for the zero polynomial.
  int degree() const { return static_cast<int>(c_.size()) - 1; }
  const std::vector<Integer>& coefficients() const { return c_; }

  Polynomial derivative() const;

  int sign_at(const Dyadic& t) const;
  /// Sign in an interval after t, or before t, without roots: the sign of the first non-zero term of the Taylor series.
  int sign_after(const Dyadic& t) const;
  int sign_before(const Dyadic& t) const;
  /// The sign in the whole interval [lo, hi] / 2^bits if a simple bound proves it, otherwise 0. Pre: 0 <= lo <= hi. The
  /// bound improves in proportion to the length of the interval.
  int sign_on(const Integer& lo, const Integer& hi, unsigned bits) const;

  friend Polynomial operator+(const Polynomial& a, const Polynomial& b);
  friend Polynomial operator-(const Polynomial& a, const Polynomial& b);
  friend Polynomial operator*(const Polynomial& a, const Polynomial& b);

 private:
  void trim();

  std::vector<Integer> c_;
};

/// p divided by the greatest common divisor of its coefficients, with positive leading coefficient.
Polynomial primitive_part(Polynomial p);

/// A primitive polynomial, which is constant if a and b have no common complex root. Zero only if both are zero.
Polynomial greatest_common_divisor(const Polynomial& a, const Polynomial& b);

/// The quotient p / divisor. Pre: divisor is primitive and divides p.
Polynomial quotient(const Polynomial& p, const Polynomial& divisor);

/// A polynomial with the same roots, all of them simple. Pre: p is not zero.
Polynomial square_free_part(const Polynomial& p);

}  // namespace volccd::detail
