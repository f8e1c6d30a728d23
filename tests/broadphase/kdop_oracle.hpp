// Which elements' swept k-DOPs overlap, in exact integers.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <boost/multiprecision/cpp_int.hpp>

#include <volccd/numerics/kdop.hpp>
#include <volccd/query/step.hpp>

namespace volccd::test {

/// x * 2^1074, which is an integer for every finite double.
using Exact = boost::multiprecision::cpp_int;
inline Exact exact(double x) {
  int exponent = 0;
  const double fraction = std::frexp(x, &exponent);
  Exact value = static_cast<std::int64_t>(std::ldexp(fraction, 53));
  const int shift = exponent - 53 + 1074;
  if (shift >= 0) return value << static_cast<unsigned>(shift);
  return value / (Exact(1) << static_cast<unsigned>(-shift));  // exact, because denormals have trailing zeros
}

/// Exact projections of each element's control points, computed by simple loops.
class KdopOracle {
 public:
  KdopOracle(const Step& step, int k) : step_(step) {
    with_axes(k);
    const Mesh& mesh = step.mesh();
    lo_.resize(mesh.element_slots());
    hi_.resize(mesh.element_slots());
    for (Index o = 0; o < mesh.element_slots(); ++o)
      for (const auto& axis : axes_) {
        bool first = true;
        Exact lo, hi;
        for (Index v : mesh.vertices(o))
          for (int c = 0; c < step.motion.control_points(); ++c) {
            const Vec3 p = step.motion.point(v, c);
            const Exact s = axis[0] * exact(p[0]) + axis[1] * exact(p[1]) + axis[2] * exact(p[2]);
            if (first || s < lo) lo = s;
            if (first || s > hi) hi = s;
            first = false;
          }
        lo_[o].push_back(lo);
        hi_[o].push_back(hi);
      }
    separation_ = exact(step.separation);
  }

  /// Whether the intervals come within the separation (times the axis's length) on every axis, in exact arithmetic.
  bool overlap(Index a, Index b) const {
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      const Exact gap = std::max<Exact>(lo_[a][i] - hi_[b][i], lo_[b][i] - hi_[a][i]);
      if (gap > 0 && gap * gap > separation_ * separation_ * axis_terms(axes_[i])) return false;
    }
    return true;
  }

  /// Whether the intervals are apart on some axis, within the range of floats, by more than the separation, `relative`
  /// of their magnitude, and the smallest step of a float.
  bool clearly_apart(Index a, Index b, double relative, double absolute) const {
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      const Exact gap = std::max<Exact>(lo_[a][i] - hi_[b][i], lo_[b][i] - hi_[a][i]);
      if (gap <= 0) continue;
      double magnitude = step_.separation * 2;
      for (const Exact& e : {lo_[a][i], hi_[a][i], lo_[b][i], hi_[b][i]})
        magnitude = std::max(magnitude, std::abs(to_double(e)));
      if (!(magnitude < 1e38)) continue;
      const double allowed =
          step_.separation * std::sqrt(double(axis_terms(axes_[i]))) + relative * magnitude + absolute;
      if (to_double(gap) > allowed) return true;
    }
    return false;
  }

 private:
  void with_axes(int k) {
    const auto take = [&](const auto& axes) { axes_.assign(axes.begin(), axes.end()); };
    switch (k) {
      case 6: take(kdop_axes<6>()); break;
      case 14: take(kdop_axes<14>()); break;
      case 16: take(kdop_axes<16>()); break;
      case 18: take(kdop_axes<18>()); break;
      case 24: take(kdop_axes<24>()); break;
      default: take(kdop_axes<26>()); break;
    }
  }
  /// e / 2^1074, with an error of about 1e-15; infinity beyond the range.
  static double to_double(const Exact& e) {
    if (e == 0) return 0;
    const Exact magnitude = boost::multiprecision::abs(e);
    const unsigned bits = boost::multiprecision::msb(magnitude);
    const unsigned drop = bits > 62 ? bits - 62 : 0;
    const double value =
        std::ldexp(static_cast<double>(static_cast<std::int64_t>(magnitude >> drop)), static_cast<int>(drop) - 1074);
    return e < 0 ? -value : value;
  }

  const Step step_;
  std::vector<std::array<int, 3>> axes_;
  std::vector<std::vector<Exact>> lo_, hi_;
  Exact separation_;
};

}  // namespace volccd::test
