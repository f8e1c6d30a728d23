// Vectors of three components over any ring, for example polynomials, integers or doubles.
#pragma once

#include <array>
#include <cstddef>

namespace volccd::detail {

template <class T>
using Vector3 = std::array<T, 3>;

template <class T>
Vector3<T> operator-(const Vector3<T>& a, const Vector3<T>& b) {
  return {T(a[0] - b[0]), T(a[1] - b[1]), T(a[2] - b[2])};
}

template <class T>
Vector3<T> operator-(const Vector3<T>& a) {
  return {T(-a[0]), T(-a[1]), T(-a[2])};
}

template <class T>
T dot(const Vector3<T>& a, const Vector3<T>& b) {
  return T(a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
}

/// Component k of the cross product a x b.
template <class T>
T cross(const Vector3<T>& a, const Vector3<T>& b, std::size_t k) {
  const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
  return T(a[i] * b[j] - a[j] * b[i]);
}

template <class T>
Vector3<T> cross(const Vector3<T>& a, const Vector3<T>& b) {
  return {cross(a, b, 0), cross(a, b, 1), cross(a, b, 2)};
}

}  // namespace volccd::detail
