// Polynomials in t with integer coefficients of any size.
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

/// numerator / 2^bits.
struct Dyadic {
  Integer numerator;
  unsigned bits;
};

/// Exact. Pre: finite.
Dyadic dyadic(double x);

/// c[0] + c[1] t + ...; the last coefficient is not zero; the zero polynomial has none.
class Polynomial {
 public:
  Polynomial() = default;
  explicit Polynomial(std::vector<Integer> coefficients);

  bool is_zero() const { return c_.empty(); }
  /// -1 for the zero polynomial.
  int degree() const { return static_cast<int>(c_.size()) - 1; }
  const std::vector<Integer>& coefficients() const { return c_; }

  Polynomial derivative() const;

  int sign_at(const Dyadic& t) const;
  /// Sign on an interval right of t, or left of it, that is free of roots: that of the first term of the Taylor series.
  int sign_after(const Dyadic& t) const;
  int sign_before(const Dyadic& t) const;
  /// The sign at all of [lo, hi] / 2^bits if a simple bound proves one, else 0. Pre: 0 <= lo <= hi. The bound tightens
  /// in proportion to the interval.
  int sign_on(const Integer& lo, const Integer& hi, unsigned bits) const;

  friend Polynomial operator+(const Polynomial& a, const Polynomial& b);
  friend Polynomial operator-(const Polynomial& a, const Polynomial& b);
  friend Polynomial operator*(const Polynomial& a, const Polynomial& b);

 private:
  void trim();

  std::vector<Integer> c_;
};

/// Divided by the greatest common divisor of the coefficients; leading coefficient positive.
Polynomial primitive_part(Polynomial p);

/// Primitive; a constant if they have no common root in the complex numbers. Zero only if both are.
Polynomial greatest_common_divisor(const Polynomial& a, const Polynomial& b);

/// p / divisor. Pre: divisor is primitive and divides p.
Polynomial quotient(const Polynomial& p, const Polynomial& divisor);

/// The same roots, each once. Pre: p is not zero.
Polynomial square_free_part(const Polynomial& p);

}  // namespace volccd::detail
