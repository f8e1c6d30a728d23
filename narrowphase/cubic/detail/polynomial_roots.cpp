#include <volccd/narrowphase/cubic/detail/polynomial_roots.hpp>

#include <utility>

namespace volccd::detail {

int quadratic_roots(double q0, double q1, double q2, std::array<double, 2>& roots) {
  // With x = t / (1 - t): q2 x^2 + 2 q1 x + q0 = 0. Vieta's form avoids cancellation: x = r / q2 and x = q0 / r. Since
  // t = x / (1 + x), x itself is never computed: t = p / (p + d) for x = p / d >= 0.
  if ((q0 > 0 && q1 >= 0 && q2 > 0) || (q0 < 0 && q1 <= 0 && q2 < 0)) return 0;
  const double discriminant = q1 * q1 - q0 * q2;
  if (!(discriminant >= 0)) return 0;
  const double root = std::sqrt(discriminant), r = q1 >= 0 ? -(q1 + root) : root - q1;
  const std::pair<double, double> fractions[2] = {{r, q2}, {q0, r}};
  int count = 0;
  for (const auto& [p, d] : fractions) {
    const bool inside = (p >= 0 && d >= 0 && p + d > 0) || (p <= 0 && d <= 0 && p + d < 0);
    if (inside) roots[static_cast<std::size_t>(count++)] = p / (p + d);
  }
  if (count == 2 && roots[1] < roots[0]) std::swap(roots[0], roots[1]);
  return count;
}

MonotonePieces monotone_pieces(const CoplanarityCubic& f) {
  const std::array<double, 3> q = f.derivative_coefficients();
  std::array<double, 2> critical;
  MonotonePieces pieces{{0, 0, 0, 0}, 0};
  const int roots = quadratic_roots(q[0], q[1], q[2], critical);
  for (int i = 0; i < roots; ++i) {
    const double t = critical[static_cast<std::size_t>(i)];
    if (t > pieces.cut[static_cast<std::size_t>(pieces.count)] && t < 1)
      pieces.cut[static_cast<std::size_t>(++pieces.count)] = t;
  }
  pieces.cut[static_cast<std::size_t>(++pieces.count)] = 1;
  return pieces;
}

double bracketed_root(const CoplanarityCubic& f, double a, double b) {
  const double fa = f.value(a), fb = f.value(b);
  const bool rising = fa < 0;
  double t = a + (b - a) * (fa / (fa - fb)), last_step = b - a;
  // Each iteration at least halves the step or the bracket.
  for (int turn = 0; turn < 200; ++turn) {
    const double value = f.value(t);
    if (value == 0) return t;
    ((value < 0) == rising ? a : b) = t;
    double step = value / f.derivative(t), next = t - step;
    if (!(next >= a && next <= b) || !(std::abs(step) <= 0.5 * last_step)) {
      next = a + 0.5 * (b - a);
      step = next - t;
    }
    if (next == t) return t;
    last_step = std::abs(step);
    t = next;
    // A Newton step this small is in the region of quadratic convergence; another step would not change t.
    if (last_step <= kUnitRoundoff * t) return t;
  }
  return t;
}

std::array<double, 2> zero_stretch(const CoplanarityCubic& f, double a, double b) {
  const int sign_a = f.sign(a), sign_b = f.sign(b);
  std::array<double, 2> stretch = {a, b};
  // `outside` has the proven sign of that end; the other end of the bracket does not.
  const auto shrink = [&](double outside, double inside, int sign) {
    for (int turn = 0; turn < 60; ++turn) {
      const double middle = outside + 0.5 * (inside - outside);
      (f.sign(middle) == sign ? outside : inside) = middle;
    }
    return outside;
  };
  if (sign_a != 0) stretch[0] = shrink(a, b, sign_a);
  if (sign_b != 0) stretch[1] = shrink(b, stretch[0], sign_b);
  return stretch;
}

}  // namespace volccd::detail
