// Vectors with 113 bits, for the truth that doubles are compared with.
#pragma once

#include <cfloat>
#include <cstddef>
#include <span>

#include <volccd/numerics/types.hpp>

namespace volccd::detail {

#if LDBL_MANT_DIG == 113  // AArch64
using Quad = long double;
#else
__extension__ using Quad = __float128;
#endif

struct Quad3 {
  Quad x = 0, y = 0, z = 0;

  Quad3() = default;
  Quad3(Quad at_x, Quad at_y, Quad at_z) : x(at_x), y(at_y), z(at_z) {}
  explicit Quad3(const Vec3& p) : x(p[0]), y(p[1]), z(p[2]) {}

  friend Quad3 operator+(const Quad3& a, const Quad3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Quad3 operator-(const Quad3& a, const Quad3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Quad3 operator*(Quad s, const Quad3& a) { return {s * a.x, s * a.y, s * a.z}; }
};

inline Quad dot(const Quad3& a, const Quad3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Quad3 cross(const Quad3& a, const Quad3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// The point at t of a curve with two or three control points.
inline Quad3 bezier(std::span<const Vec3> p, Quad t) {
  const Quad s = 1 - t;
  if (p.size() == 2) return s * Quad3(p[0]) + t * Quad3(p[1]);
  return s * s * Quad3(p[0]) + 2 * s * t * Quad3(p[1]) + t * t * Quad3(p[2]);
}

}  // namespace volccd::detail
