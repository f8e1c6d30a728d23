// The oriented bounding box (OBB) of a moving element, as a scalar template over any number type: Section 7.2 of the
// paper compares its cost with that of k-DOPs. Guarantee and preconditions are those of moving_kdop.hpp.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include <volccd/paper2011/moving_kdop.hpp>

namespace volccd::reference {

/// The points center + sum u_i axes[i] with |u_i| <= half[i]. The axes are orthonormal up to rounding (the dot products
/// of two of them differ from 0, or 1, by less than 2^-48).
template <class Scalar>
struct MovingObb {
  Vector3<Scalar> center;
  std::array<Vector3<Scalar>, 3> axes;
  Vector3<Scalar> half;
};

namespace bounds_detail {

/// Relative allowance for all rounding errors of the fit and of the test of OBBs: each of them is a sum of fewer than
/// 100 errors of 2^-53, relative to the magnitudes that the allowance is multiplied by.
inline constexpr double kObbRounding = 0x1p-46;

template <class Scalar>
Scalar size_of(const Vector3<Scalar>& v) {
  using std::abs;
  return abs(v[0]) + abs(v[1]) + abs(v[2]);
}

/// A symmetric matrix and the rotations that make it diagonal.
template <class Scalar>
struct Jacobi {
  std::array<Vector3<Scalar>, 3> matrix, columns;

  /// Makes the element (p, q) zero.
  void rotate(std::size_t p, std::size_t q) {
    using std::abs;
    using std::sqrt;
    const Scalar off = matrix[p][q];
    if (off == Scalar(0)) return;
    const Scalar theta = (matrix[q][q] - matrix[p][p]) / (Scalar(2) * off);
    const Scalar size = Scalar(1) / (abs(theta) + sqrt(theta * theta + Scalar(1)));
    const Scalar t = theta < Scalar(0) ? -size : size;
    const Scalar c = Scalar(1) / sqrt(t * t + Scalar(1)), s = t * c;
    const std::size_t r = 3 - p - q;
    matrix[p][p] = matrix[p][p] - t * off;
    matrix[q][q] = matrix[q][q] + t * off;
    matrix[p][q] = matrix[q][p] = Scalar(0);
    const Scalar rp = matrix[r][p], rq = matrix[r][q];
    matrix[r][p] = matrix[p][r] = c * rp - s * rq;
    matrix[r][q] = matrix[q][r] = s * rp + c * rq;
    for (std::size_t i = 0; i < 3; ++i) {
      const Scalar x = columns[p][i], y = columns[q][i];
      columns[p][i] = c * x - s * y;
      columns[q][i] = s * x + c * y;
    }
  }

  /// At most 6 sweeps; fewer once the elements off the diagonal are under 1e-6 of those on it, since the box needs no
  /// better directions.
  void run() {
    using std::abs;
    for (int sweep = 0; sweep < 6; ++sweep) {
      const Scalar off = abs(matrix[0][1]) + abs(matrix[0][2]) + abs(matrix[1][2]);
      const Scalar diagonal = abs(matrix[0][0]) + abs(matrix[1][1]) + abs(matrix[2][2]);
      if (off <= Scalar(1e-6) * diagonal) return;
      rotate(0, 1);
      rotate(0, 2);
      rotate(1, 2);
    }
  }
};

template <class Scalar>
Vector3<Scalar> normalised(const Vector3<Scalar>& v) {
  using std::sqrt;
  const Scalar scale = Scalar(1) / sqrt(dot(v, v));
  return {scale * v[0], scale * v[1], scale * v[2]};
}

/// Principal axes of the positions, made orthonormal again after the rotations.
template <class Scalar>
std::array<Vector3<Scalar>, 3> principal_axes(std::span<const MovingPoint<Scalar>> points,
                                              const Vector3<Scalar>& mean) {
  Jacobi<Scalar> jacobi;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      jacobi.matrix[i][j] = Scalar(0);
      jacobi.columns[i][j] = Scalar(i == j ? 1 : 0);
    }
  for (const MovingPoint<Scalar>& p : points)
    for (const Vector3<Scalar>& d : {p.x0 - mean, p.x1 - mean})
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = i; j < 3; ++j) jacobi.matrix[i][j] = jacobi.matrix[i][j] + d[i] * d[j];
  for (std::size_t i = 1; i < 3; ++i)
    for (std::size_t j = 0; j < i; ++j) jacobi.matrix[i][j] = jacobi.matrix[j][i];
  jacobi.run();
  const Vector3<Scalar> first = normalised(jacobi.columns[0]);
  const Scalar along = dot(first, jacobi.columns[1]);
  const Vector3<Scalar>& c = jacobi.columns[1];
  const Vector3<Scalar> second =
      normalised<Scalar>({c[0] - along * first[0], c[1] - along * first[1], c[2] - along * first[2]});
  return {first, second, cross(first, second)};
}

template <class Scalar>
Vector3<Scalar> mean_of(std::span<const MovingPoint<Scalar>> points) {
  const Scalar share = Scalar(0.5) / Scalar(static_cast<double>(points.size()));
  Vector3<Scalar> mean;
  for (std::size_t i = 0; i < 3; ++i) {
    Scalar sum = points[0].x0[i] + points[0].x1[i];
    for (const MovingPoint<Scalar>& p : points.subspan(1)) sum = sum + p.x0[i] + p.x1[i];
    mean[i] = share * sum;
  }
  return mean;
}

}  // namespace bounds_detail

/// The box over the positions at both ends along their principal axes (Gottschalk et al. 1996). By convexity it holds
/// the element at all times between.
template <class Scalar>
MovingObb<Scalar> moving_obb(std::span<const MovingPoint<Scalar>> points) {
  using std::abs;
  const Vector3<Scalar> mean = bounds_detail::mean_of(points);
  MovingObb<Scalar> box;
  box.axes = bounds_detail::principal_axes(points, mean);
  const auto along_axes = [&](const Vector3<Scalar>& x) -> Vector3<Scalar> {
    const Vector3<Scalar> d = x - mean;
    return {dot(box.axes[0], d), dot(box.axes[1], d), dot(box.axes[2], d)};
  };
  Vector3<Scalar> low = along_axes(points[0].x0), high = low;
  bounds_detail::extend(low, high, along_axes(points[0].x1));
  for (const MovingPoint<Scalar>& p : points.subspan(1)) {
    bounds_detail::extend(low, high, along_axes(p.x0));
    bounds_detail::extend(low, high, along_axes(p.x1));
  }
  const Scalar rounding = Scalar(bounds_detail::kObbRounding) *
                          (bounds_detail::size_of(low) + bounds_detail::size_of(high) + bounds_detail::size_of(mean));
  Vector3<Scalar> middle;
  for (std::size_t i = 0; i < 3; ++i) {
    middle[i] = Scalar(0.5) * (low[i] + high[i]);
    box.half[i] = Scalar(0.5) * (high[i] - low[i]) + rounding;
  }
  for (std::size_t k = 0; k < 3; ++k)
    box.center[k] = mean[k] + (middle[0] * box.axes[0][k] + middle[1] * box.axes[1][k] + middle[2] * box.axes[2][k]);
  return box;
}

/// Whether two boxes are disjoint along one of the 15 axes that suffice for boxes: the axes of both, and the cross
/// products of one of each.
template <class Scalar>
bool apart(const MovingObb<Scalar>& a, const MovingObb<Scalar>& b) {
  using std::abs;
  const Vector3<Scalar> between = b.center - a.center;
  Vector3<Scalar> t;                            // `between` along the axes of a
  std::array<Vector3<Scalar>, 3> r, magnitude;  // the axes of b along those of a
  for (std::size_t i = 0; i < 3; ++i) {
    t[i] = dot(between, a.axes[i]);
    for (std::size_t j = 0; j < 3; ++j) {
      r[i][j] = dot(a.axes[i], b.axes[j]);
      magnitude[i][j] = abs(r[i][j]);
    }
  }
  const Scalar rounding = Scalar(bounds_detail::kObbRounding) *
                          (bounds_detail::size_of(t) + bounds_detail::size_of(a.half) + bounds_detail::size_of(b.half));
  for (std::size_t i = 0; i < 3; ++i)
    if (abs(t[i]) > a.half[i] + dot(b.half, magnitude[i]) + rounding) return true;
  for (std::size_t j = 0; j < 3; ++j) {
    const Scalar reach = a.half[0] * magnitude[0][j] + a.half[1] * magnitude[1][j] + a.half[2] * magnitude[2][j];
    if (abs(t[0] * r[0][j] + t[1] * r[1][j] + t[2] * r[2][j]) > reach + b.half[j] + rounding) return true;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const Scalar reach = a.half[i1] * magnitude[i2][j] + a.half[i2] * magnitude[i1][j] +
                           b.half[j1] * magnitude[i][j2] + b.half[j2] * magnitude[i][j1];
      if (abs(t[i2] * r[i1][j] - t[i1] * r[i2][j]) > reach + rounding) return true;
    }
  }
  return false;
}

}  // namespace volccd::reference
