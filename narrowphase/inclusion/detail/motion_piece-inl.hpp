// Inline definitions for motion_piece.hpp, which includes this file.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include <volccd/narrowphase/inclusion/detail/inclusion_bounds.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd::detail {

constexpr double binomial(int n, int k) { return k == 0 ? 1 : binomial(n - 1, k - 1) * n / k; }

template <int kPoints>
MotionPiece<kPoints>::MotionPiece(const BoundedTest<kPoints>& test, double lo, double hi)
    : test_(test), lo_(lo), hi_(hi) {
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& e = test.differences()[i];
    if constexpr (kPoints == 2) {
      e_[i] = {between(e[0], e[1], lo), between(e[0], e[1], hi)};
    } else {
      const Vec3 first = between(e[0], e[1], lo), second = between(e[1], e[2], lo);
      e_[i] = {between(first, second, lo), between(first, second, hi),
               between(between(e[0], e[1], hi), between(e[1], e[2], hi), hi)};
    }
  }
}

template <int kPoints>
double MotionPiece<kPoints>::error(int k) const {
  return binomial(kDegree, k) * test_.coplanarity_error() + test_.coplanarity_underflow();
}

template <int kPoints>
bool MotionPiece<kPoints>::prove_never_coplanar() {
  constexpr int n = kPoints - 1;
  std::array<Vec3, 2 * n + 1> normal;
  for (Vec3& v : normal) v.setZero();
  b_.fill(0);
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j)
      normal[static_cast<std::size_t>(i + j)] +=
          binomial(n, i) * binomial(n, j) *
          e_[1][static_cast<std::size_t>(i)].cross(e_[2][static_cast<std::size_t>(j)]);
  for (int i = 0; i <= n; ++i)
    for (int k = 0; k <= 2 * n; ++k)
      b_[static_cast<std::size_t>(i + k)] +=
          binomial(n, i) * e_[0][static_cast<std::size_t>(i)].dot(normal[static_cast<std::size_t>(k)]);
  bool above = true, below = true;
  for (int k = 0; k <= kDegree; ++k) {
    const double bound = error(k);
    above = above && b_[static_cast<std::size_t>(k)] > bound;
    below = below && b_[static_cast<std::size_t>(k)] < -bound;
  }
  return above || below;
}

template <int kPoints>
bool MotionPiece<kPoints>::vanishes() const {
  for (int k = 0; k <= kDegree; ++k)
    if (std::abs(b_[static_cast<std::size_t>(k)]) > error(k)) return false;
  return true;
}

template <int kPoints>
int MotionPiece<kPoints>::sign_at_start() const {
  return b_[0] > error(0) ? 1 : b_[0] < -error(0) ? -1 : 0;
}

template <int kPoints>
int MotionPiece<kPoints>::sign_at_end() const {
  return b_[kDegree] > error(kDegree) ? 1 : b_[kDegree] < -error(kDegree) ? -1 : 0;
}

template <int kPoints>
double MotionPiece<kPoints>::coefficient(int k) const {
  return b_[static_cast<std::size_t>(k)] * (1 / binomial(kDegree, k));
}

/// Horner's scheme for Bernstein coefficients that include their binomials.
template <int kPoints>
double MotionPiece<kPoints>::value(double s) const {
  const double r = 1 - s;
  double sum = b_[0], power = 1;
  for (std::size_t k = 1; k <= kDegree; ++k) {
    power *= s;
    sum = sum * r + b_[k] * power;
  }
  return sum;
}

template <int kPoints>
double MotionPiece<kPoints>::value_error() const {
  double greatest = 0;
  for (int k = 0; k <= kDegree; ++k) greatest = std::max(greatest, std::abs(coefficient(k)));
  return test_.coplanarity_error() * (1 + 16 * kUnitRoundoff) + (kDegree + 2) * test_.coplanarity_underflow() +
         value_error_factor(kDegree) * greatest;
}

/// De Casteljau's algorithm: its intermediate values are the coefficients on both sides of s.
template <int kPoints>
template <bool kBefore>
bool MotionPiece<kPoints>::one_sign(double s) const {
  std::array<double, kDegree + 1> c;
  for (int k = 0; k <= kDegree; ++k) c[static_cast<std::size_t>(k)] = coefficient(k);
  const double r = 1 - s;
  double min = kBefore ? c[0] : c[kDegree], greatest = min;
  for (std::size_t level = kDegree; level > 0; --level) {
    for (std::size_t k = 0; k < level; ++k) c[k] = r * c[k] + s * c[k + 1];
    const double next = kBefore ? c[0] : c[level - 1];
    min = std::min(min, next);
    greatest = std::max(greatest, next);
  }
  const double error = value_error();
  return min > error || greatest < -error;
}

template <int kPoints>
bool MotionPiece<kPoints>::never_coplanar_before(double s) const {
  return one_sign<true>(s);
}

template <int kPoints>
bool MotionPiece<kPoints>::never_coplanar_after(double s) const {
  return one_sign<false>(s);
}

/// Derivative of value(), rounded.
template <int kPoints>
double MotionPiece<kPoints>::slope(double s) const {
  const double r = 1 - s;
  double sum = 0, power = 1;
  for (int k = 0; k < kDegree; ++k) {
    const double rise = coefficient(k + 1) - coefficient(k);
    sum = sum * r + rise * (binomial(kDegree - 1, k) * power);
    power *= s;
  }
  return kDegree * sum;
}

template <int kPoints>
double MotionPiece<kPoints>::likely_root() const {
  if (b_[0] * b_[kDegree] < 0) {
    // Illinois method: false position, where the value at an end that is kept is halved.
    double a = 0, b = 1, fa = b_[0], fb = b_[kDegree], c = 0.5;
    const double enough = 0x1p-10 * std::max(std::abs(fa), std::abs(fb));
    for (int round = 0; round < 8; ++round) {
      c = a + (b - a) * (fa / (fa - fb));
      const double fc = value(c);
      if (std::abs(fc) <= enough) break;
      if ((fc < 0) == (fa < 0)) {
        a = c, fa = fc, fb *= 0.5;
      } else {
        b = c, fb = fc, fa *= 0.5;
      }
    }
    for (int round = 0; round < 2; ++round) c -= value(c) / slope(c);
    return c >= 0 && c <= 1 ? c : 0.5;
  }
  int nearest = 0;
  const double sign = b_[0] + b_[kDegree] < 0 ? -1 : 1;
  for (int k = 1; k <= kDegree; ++k)
    if (sign * coefficient(k) < sign * coefficient(nearest)) nearest = k;
  return static_cast<double>(nearest) / kDegree;
}

template <int kPoints>
bool MotionPiece<kPoints>::separated_along(const Vec3& axis) const {
  double ahead = kInfinity, behind = kInfinity;
  for (std::size_t c = 0; c < kPoints; ++c) {
    const double p1 = axis.dot(e_[0][c]), p2 = axis.dot(e_[1][c]), p3 = axis.dot(e_[2][c]);
    const double low = std::min(p2, p3), high = std::max(p2, p3);
    if (test_.kind() == FeatureKind::vf) {
      ahead = std::min(ahead, std::min(p1, low));
      behind = std::min(behind, -std::max(p1, high));
    } else {
      ahead = std::min(ahead, low - std::max(p1, 0.0));
      behind = std::min(behind, std::min(p1, 0.0) - high);
    }
  }
  const double rounding = gap_error_factor(kPoints - 1) * axis.cwiseAbs().dot(test_.extent()) + kGapUnderflow;
  return std::max(ahead, behind) > rounding;
}

/// Products of the curve and the motion, and the square of the curve's length, as Bernstein coefficients of degree 4,
/// each times its binomial.
template <int kPoints>
bool MotionPiece<kPoints>::separated_along_curve(const AxisCurve& n) const {
  using Quartic = std::array<double, 5>;
  const auto along = [&](const Curve& e) {
    Quartic q{};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t c = 0; c < kPoints; ++c)
        q[i + c] += binomial(2, static_cast<int>(i)) * binomial(kPoints - 1, static_cast<int>(c)) * n[i].dot(e[c]);
    if constexpr (kPoints == 2)
      for (std::size_t k = 4; k > 0; --k) q[k] += q[k - 1];
    return q;
  };
  const Quartic p1 = along(e_[0]), p2 = along(e_[1]), p3 = along(e_[2]);
  const Quartic square = {n[0].squaredNorm(), 4 * n[0].dot(n[1]), 2 * n[0].dot(n[2]) + 4 * n[1].squaredNorm(),
                          4 * n[1].dot(n[2]), n[2].squaredNorm()};
  const Vec3 greatest = n[0].cwiseAbs().cwiseMax(n[1].cwiseAbs()).cwiseMax(n[2].cwiseAbs());
  const double rounding = curve_error_factor(kPoints - 1) * greatest.dot(test_.extent()) + kGapUnderflow;
  const double length_error = kCurveLengthError * (1 + greatest.squaredNorm());
  for (std::size_t k = 0; k < 5; ++k) {
    const double weight = binomial(4, static_cast<int>(k)), low = std::min(p2[k], p3[k]);
    const double gap = test_.kind() == FeatureKind::vf ? std::min(p1[k], low) : low - std::max(p1[k], 0.0);
    const double length = 0.5 * (square[k] + weight * (1 + length_error));  // of the axis, at most
    if (!(gap > weight * rounding + test_.separation() * length)) return false;
  }
  return true;
}

template <int kPoints>
Vec3 MotionPiece<kPoints>::support(const Vec3& axis) const {
  Vec3 best = Vec3::Zero();
  double min = kInfinity;
  const auto offer = [&](const Vec3& difference) {
    const double along = axis.dot(difference);
    if (!(along < min)) return;
    min = along;
    best = difference;
  };
  for (std::size_t c = 0; c < kPoints; ++c) {
    offer(e_[1][c]);
    offer(e_[2][c]);
    if (test_.kind() == FeatureKind::vf) {
      offer(e_[0][c]);
    } else {
      offer(e_[1][c] - e_[0][c]);
      offer(e_[2][c] - e_[0][c]);
    }
  }
  return best;
}

template <int kPoints>
auto MotionPiece<kPoints>::quadric(const Vec3& direction, std::size_t i, std::size_t j) const -> Quadric {
  constexpr std::size_t n = kPoints - 1;
  Quadric q{};
  for (std::size_t a = 0; a <= n; ++a)
    for (std::size_t b = 0; b <= n; ++b)
      q[a + b] +=
          binomial(n, static_cast<int>(a)) * binomial(n, static_cast<int>(b)) * direction.dot(e_[i][a].cross(e_[j][b]));
  return q;
}

template <int kPoints>
bool MotionPiece<kPoints>::overlap_along(const Vec3& direction) const {
  const Quadric q12 = quadric(direction, 0, 1), q13 = quadric(direction, 0, 2), q23 = quadric(direction, 1, 2);
  const Vec3 l = direction.cwiseAbs();
  const auto magnitude = [&](const Vec3& x, const Vec3& y) {
    return l.x() * (x.y() * y.z() + x.z() * y.y()) + l.y() * (x.z() * y.x() + x.x() * y.z()) +
           l.z() * (x.x() * y.y() + x.y() * y.x());
  };
  const std::array<Vec3, 3>& m = test_.extents();
  const double factor = quadric_error_factor(kPoints - 1), underflow = kDeterminantUnderflow * (1 + l.sum());
  const double e12 = factor * magnitude(m[0], m[1]), e13 = factor * magnitude(m[0], m[2]),
               e23 = factor * magnitude(m[1], m[2]);
  const double sign = q12[0] < 0 ? -1 : 1;
  constexpr int degree = 2 * (kPoints - 1);
  for (int k = 0; k <= degree; ++k) {
    const std::size_t at = static_cast<std::size_t>(k);
    const double weight = binomial(degree, k);
    const double s12 = sign * q12[at] - weight * e12 - underflow, s13 = -sign * q13[at] - weight * e13 - underflow;
    if (!(s12 > 0 && s13 > 0)) return false;
    if (test_.kind() == FeatureKind::vf) {
      // In the projection, the corners as seen from the vertex are in cyclic order: (1,2), (2,3), (3,1).
      if (!(sign * q23[at] > weight * e23 + underflow)) return false;
    } else {
      // The ends of edge 2 are on different sides of edge 1, and those of edge 1 on different sides of edge 2.
      if (!(-sign * q23[at] > weight * e23 + underflow)) return false;
      if (!(sign * (q23[at] + q12[at] - q13[at]) > weight * (e12 + e13 + e23) + 3 * underflow)) return false;
    }
  }
  return true;
}

template <int kPoints>
double MotionPiece<kPoints>::before_first_root(double guess, double tolerance) const {
  const double rise = b_[kDegree] > b_[0] ? 1 : -1;
  // There is only one root if the polynomial is certainly monotone.
  double min = kInfinity;
  for (int k = 1; k <= kDegree; ++k) min = std::min(min, rise * (coefficient(k) - coefficient(k - 1)));
  if (!(min > 0)) return -1;
  const double error = value_error();
  min = kDegree * (min - 2 * error);
  if (!(min > 0)) return -1;
  const double root = guess - value(guess) / slope(guess);
  // Outside of [0, 1] the polynomial and its signs are not valid for the motion. This test also excludes NaN.
  if (!(root >= 0 && root <= 1)) return -1;
  const double width = hi_ - lo_;
  for (double margin = std::max(4 * error / min, 0x1p-44); 2 * margin * width < tolerance; margin *= 8) {
    const double before = root - margin, after = root + margin;
    // The caller guarantees that the signs at the ends are certain.
    if (after < 1 && !(rise * value(after) > error)) continue;
    if (before <= 0) return lo_;
    if (-rise * value(before) > error) return std::max(lo_, (lo_ + before * width) * (1 - 4 * kUnitRoundoff));
  }
  return -1;
}

}  // namespace volccd::detail
