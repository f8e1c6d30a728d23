#include <volccd/narrowphase/exact/detail/integer_polynomial.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace volccd::detail {
namespace {

/// Computes p(x / 2^bits) 2^(bits degree) by Horner's scheme, without the coefficients for which `skip` is true.
template <class Skip>
Integer scaled_value(const std::vector<Integer>& c, const Integer& x, unsigned bits, Skip skip) {
  Integer value = 0, term;
  unsigned shift = 0;
  for (std::size_t i = c.size(); i-- > 0; shift += bits) {
    value *= x;
    if (skip(c[i])) continue;
    term = c[i];
    term <<= shift;
    value += term;
  }
  return value;
}

/// Remainder of a divided by b, multiplied by a positive or negative factor.
Polynomial pseudo_remainder(const Polynomial& a, const Polynomial& b) {
  std::vector<Integer> r = a.coefficients();
  const std::vector<Integer>& d = b.coefficients();
  while (r.size() >= d.size()) {
    const Integer top = r.back();
    const std::size_t shift = r.size() - d.size();
    for (Integer& c : r) c *= d.back();
    for (std::size_t i = 0; i < d.size(); ++i) r[shift + i] -= top * d[i];
    while (!r.empty() && r.back().is_zero()) r.pop_back();
    if (r.empty()) break;
  }
  return Polynomial(std::move(r));
}

}  // namespace

Dyadic dyadic(double x) {
  assert(std::isfinite(x));
  int exponent;
  const double mantissa = std::frexp(x, &exponent);
  Dyadic result{Integer(static_cast<long long>(std::ldexp(mantissa, 53))), 0};
  exponent -= 53;
  if (exponent < 0) {
    result.bits = static_cast<unsigned>(-exponent);
    if (result.numerator.is_zero()) return {0, 0};
    const unsigned zeros = std::min(result.bits, static_cast<unsigned>(lsb(Integer(abs(result.numerator)))));
    result.numerator >>= zeros;
    result.bits -= zeros;
  } else {
    result.numerator <<= exponent;
  }
  return result;
}

Polynomial::Polynomial(std::vector<Integer> coefficients) : c_(std::move(coefficients)) { trim(); }

void Polynomial::trim() {
  while (!c_.empty() && c_.back().is_zero()) c_.pop_back();
}

Polynomial Polynomial::derivative() const {
  std::vector<Integer> d(c_.empty() ? 0 : c_.size() - 1);
  for (std::size_t i = 0; i < d.size(); ++i) d[i] = c_[i + 1] * static_cast<unsigned>(i + 1);
  return Polynomial(std::move(d));
}

int Polynomial::sign_at(const Dyadic& t) const {
  return sign_of(scaled_value(c_, t.numerator, t.bits, [](const Integer&) { return false; }));
}

int Polynomial::sign_after(const Dyadic& t) const {
  const int sign = sign_at(t);
  return sign != 0 || is_zero() ? sign : derivative().sign_after(t);
}

int Polynomial::sign_before(const Dyadic& t) const {
  const int sign = sign_at(t);
  return sign != 0 || is_zero() ? sign : -derivative().sign_before(t);
}

int Polynomial::sign_on(const Integer& lo, const Integer& hi, unsigned bits) const {
  // Terms with positive coefficients increase with t, the others decrease.
  const auto negative = [](const Integer& c) { return c.sign() < 0; };
  const auto positive = [](const Integer& c) { return c.sign() > 0; };
  const Integer min = scaled_value(c_, lo, bits, negative) + scaled_value(c_, hi, bits, positive);
  if (min.sign() > 0) return 1;
  const Integer greatest = scaled_value(c_, hi, bits, negative) + scaled_value(c_, lo, bits, positive);
  return greatest.sign() < 0 ? -1 : 0;
}

Polynomial operator+(const Polynomial& a, const Polynomial& b) {
  if (a.c_.size() < b.c_.size()) return b + a;
  Polynomial sum = a;
  for (std::size_t i = 0; i < b.c_.size(); ++i) sum.c_[i] += b.c_[i];
  sum.trim();
  return sum;
}

Polynomial operator-(const Polynomial& a, const Polynomial& b) {
  Polynomial difference = a;
  if (difference.c_.size() < b.c_.size()) difference.c_.resize(b.c_.size());
  for (std::size_t i = 0; i < b.c_.size(); ++i) difference.c_[i] -= b.c_[i];
  difference.trim();
  return difference;
}

Polynomial operator*(const Polynomial& a, const Polynomial& b) {
  Polynomial product;
  if (a.is_zero() || b.is_zero()) return product;
  product.c_.resize(a.c_.size() + b.c_.size() - 1);
  for (std::size_t i = 0; i < a.c_.size(); ++i)
    for (std::size_t j = 0; j < b.c_.size(); ++j) product.c_[i + j] += a.c_[i] * b.c_[j];
  return product;
}

Polynomial primitive_part(Polynomial p) {
  if (p.is_zero()) return p;
  std::vector<Integer> c = p.coefficients();
  Integer content = 0;
  for (const Integer& x : c) content = gcd(content, x);
  if (c.back().sign() < 0) content = -content;
  for (Integer& x : c) x /= content;
  return Polynomial(std::move(c));
}

Polynomial greatest_common_divisor(const Polynomial& a, const Polynomial& b) {
  Polynomial p = primitive_part(a), q = primitive_part(b);
  if (p.degree() < q.degree()) std::swap(p, q);
  while (!q.is_zero()) {
    if (q.degree() == 0) return q;
    Polynomial r = primitive_part(pseudo_remainder(p, q));
    p = std::move(q);
    q = std::move(r);
  }
  return p;
}

Polynomial quotient(const Polynomial& p, const Polynomial& divisor) {
  std::vector<Integer> r = p.coefficients();
  const std::vector<Integer>& d = divisor.coefficients();
  assert(!d.empty() && r.size() >= d.size());
  std::vector<Integer> q(r.size() - d.size() + 1);
  for (std::size_t k = q.size(); k-- > 0;) {
    q[k] = r[k + d.size() - 1] / d.back();
    for (std::size_t i = 0; i < d.size(); ++i) r[k + i] -= q[k] * d[i];
  }
  assert(std::all_of(r.begin(), r.end(), [](const Integer& x) { return x.is_zero(); }));
  return Polynomial(std::move(q));
}

Polynomial square_free_part(const Polynomial& p) {
  assert(!p.is_zero());
  if (p.degree() <= 1) return p;
  const Polynomial repeated = greatest_common_divisor(p, p.derivative());
  return repeated.degree() == 0 ? p : quotient(p, repeated);
}

}  // namespace volccd::detail
