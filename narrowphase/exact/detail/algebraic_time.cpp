#include <volccd/narrowphase/exact/detail/algebraic_time.hpp>

#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace volccd::detail {
namespace {

/// After this many bisections, interval bounds have decided most signs, and the value is probably zero.
constexpr int kBisectionsBeforeDivisor = 16;

/// After this many bisections, distinct roots are mostly separated; computing the square-free part costs more.
constexpr unsigned kBisectionsBeforeSquareFree = 6;

/// Replaces p(x) by p(x + 1).
void shift_by_one(std::vector<Integer>& c) {
  for (std::size_t i = 0; i + 1 < c.size(); ++i)
    for (std::size_t j = c.size() - 1; j-- > i;) c[j] += c[j + 1];
}

/// Number of sign changes in the coefficients of (1 + x)^n p(1 / (1 + x)): the number of roots of p in (0,1), or
/// greater by an even number.
int sign_changes(const std::vector<Integer>& p) {
  std::vector<Integer> c(p.rbegin(), p.rend());
  shift_by_one(c);
  int changes = 0, last = 0;
  for (const Integer& x : c) {
    const int sign = x.sign();
    if (sign == 0) continue;
    if (sign == -last) ++changes;
    last = sign;
  }
  return changes;
}

/// Whether one polynomial is a multiple of the other. Pre: neither is zero.
bool proportional(const Polynomial& p, const Polynomial& q) {
  const std::vector<Integer>&a = p.coefficients(), &b = q.coefficients();
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i + 1 < a.size(); ++i)
    if (a[i] * b.back() != b[i] * a.back()) return false;
  return true;
}

class Isolation {
 public:
  Isolation(std::shared_ptr<const Polynomial> p, unsigned max_bits) : p_(std::move(p)), max_bits_(max_bits) {}

  /// Adds the roots in the open interval (index, index + 1) / 2^bits in ascending order; `c` is the polynomial with
  /// this interval mapped to (0,1). Returns false if max_bits is not sufficient.
  bool search(const std::vector<Integer>& c, const Integer& index, unsigned bits) {
    const int changes = sign_changes(c);
    if (changes == 0) return true;
    if (changes == 1) {
      roots_.emplace_back(p_, index, bits);
      return true;
    }
    if (bits == max_bits_) return false;
    // 2^n p(x / 2) is the polynomial with the left half mapped to (0,1).
    std::vector<Integer> half = c;
    for (std::size_t i = 0; i < half.size(); ++i) half[i] <<= half.size() - 1 - i;
    if (!search(half, 2 * index, bits + 1)) return false;
    shift_by_one(half);
    if (half.front().is_zero()) roots_.emplace_back(Dyadic{2 * index + 1, bits + 1});
    return search(half, 2 * index + 1, bits + 1);
  }

  std::vector<AlgebraicTime>& roots() { return roots_; }

 private:
  std::shared_ptr<const Polynomial> p_;
  unsigned max_bits_;
  std::vector<AlgebraicTime> roots_;
};

std::vector<AlgebraicTime> roots_inside(const Polynomial& p) {
  const auto shared = std::make_shared<const Polynomial>(p);
  Isolation quick(shared, kBisectionsBeforeSquareFree);
  if (quick.search(p.coefficients(), 0, 0)) return std::move(quick.roots());
  // Bisection terminates if each root is simple.
  const auto square_free = std::make_shared<const Polynomial>(square_free_part(p));
  Isolation thorough(square_free, std::numeric_limits<unsigned>::max());
  thorough.search(square_free->coefficients(), 0, 0);
  return std::move(thorough.roots());
}

}  // namespace

AlgebraicTime::AlgebraicTime(std::shared_ptr<const Polynomial> p, const Integer& index, unsigned bits)
    : p_(std::move(p)), lo_(index), hi_(index + 1), bits_(bits), before_(p_->sign_after({lo_, bits_})) {}

void AlgebraicTime::express_in(unsigned bits) {
  if (bits <= bits_) return;
  lo_ <<= bits - bits_;
  hi_ <<= bits - bits_;
  bits_ = bits;
}

int AlgebraicTime::compare(const Dyadic& t) {
  express_in(t.bits);
  Integer x = t.numerator;
  x <<= bits_ - t.bits;
  if (exact()) return Integer(lo_ - x).sign();
  if (x <= lo_) return 1;
  if (x >= hi_) return -1;
  const int sign = p_->sign_at({x, bits_});
  if (sign == 0)
    lo_ = hi_ = x;
  else
    (sign == before_ ? lo_ : hi_) = x;
  return sign == 0 ? 0 : sign == before_ ? 1 : -1;
}

void AlgebraicTime::bisect() {
  if (hi_ - lo_ == 1) express_in(bits_ + 1);
  compare({Integer((lo_ + hi_) >> 1), bits_});
}

bool AlgebraicTime::is_root_of(const Polynomial& g) const {
  const Polynomial common = greatest_common_divisor(*p_, g);
  // The polynomial has no other root in the interval, and this root is simple.
  return common.degree() > 0 && common.sign_after({lo_, bits_}) != common.sign_before({hi_, bits_});
}

int AlgebraicTime::sign(const Polynomial& g) {
  if (g.degree() <= 0) return g.is_zero() ? 0 : g.coefficients().front().sign();
  if (!exact() && proportional(g, *p_)) return 0;
  for (int bisections = 0; !exact(); ++bisections) {
    if (const int sign = g.sign_on(lo_, hi_, bits_)) return sign;
    if (bisections == kBisectionsBeforeDivisor && is_root_of(g)) return 0;
    bisect();
  }
  return g.sign_at({lo_, bits_});
}

double AlgebraicTime::guess() const {
  const auto time = [&](const Integer& x) { return std::ldexp(x.convert_to<double>(), -static_cast<int>(bits_)); };
  double lo = time(lo_), hi = time(hi_);
  if (exact()) return lo;
  unsigned max_bits = 0;
  for (const Integer& c : p_->coefficients())
    if (!c.is_zero()) max_bits = std::max(max_bits, static_cast<unsigned>(msb(Integer(abs(c)))));
  std::vector<double> coefficients;
  for (const Integer& c : p_->coefficients())
    coefficients.push_back(Integer(c >> (max_bits > 1000 ? max_bits - 1000 : 0)).convert_to<double>());
  for (int round = 0; round < std::numeric_limits<double>::digits; ++round) {
    const double middle = lo + (hi - lo) / 2;
    double value = 0;
    for (std::size_t i = coefficients.size(); i-- > 0;) value = value * middle + coefficients[i];
    (value * before_ > 0 ? lo : hi) = middle;
  }
  return lo;
}

double AlgebraicTime::floor() {
  if (compare({1, 0}) == 0) return 1;
  // Non-negative doubles have the same order as their bits. Each candidate except zero is compared with the time before
  // it becomes the lower bound.
  std::uint64_t below = 0, above = std::bit_cast<std::uint64_t>(1.0);
  const auto bound = [&](std::uint64_t bits) {
    (compare(dyadic(std::bit_cast<double>(bits))) < 0 ? above : below) = bits;
    return above == bits;
  };
  // Tests at increasing distances from the guess, until the time is between two of them.
  const std::uint64_t start = std::bit_cast<std::uint64_t>(guess());
  if (start > below && start < above) {
    const bool down = bound(start);
    for (std::uint64_t step = 1; step < above - below; step *= 8)
      if (bound(down ? above - step : below + step) != down) break;
  }
  while (above - below > 1) bound(below + (above - below) / 2);
  return std::bit_cast<double>(below);
}

int AlgebraicTime::sign_before(const Polynomial& f) const {
  return exact() ? f.sign_before({lo_, bits_}) : f.sign_after({lo_, bits_});
}

int AlgebraicTime::sign_after(const Polynomial& f) const {
  return exact() ? f.sign_after({hi_, bits_}) : f.sign_before({hi_, bits_});
}

std::vector<AlgebraicTime> roots_in_step(const Polynomial& p) {
  assert(!p.is_zero());
  std::vector<AlgebraicTime> roots = roots_inside(p);
  if (p.sign_at({1, 0}) == 0) roots.emplace_back(Dyadic{1, 0});
  return roots;
}

}  // namespace volccd::detail
