#include <algorithm>
#include <limits>

#include <boost/multiprecision/cpp_int.hpp>

#include <volccd/narrowphase/overlap/detail/hull_overlap.hpp>
#include <volccd/numerics/hull_simplex.hpp>
#include <volccd/numerics/odd_parts.hpp>

namespace volccd::detail {

namespace {

/// Integers of any size. Up to 768 bits (coordinates of about 60 bits relative to their common unit) they need no
/// allocation.
using WideInteger =
    boost::multiprecision::number<boost::multiprecision::cpp_int_backend<768, 0>, boost::multiprecision::et_off>;
using WideSimplex = HullSimplex<WideInteger>;
using WidePoint = Vector3<WideInteger>;

/// Coordinates as integer multiples of a power of two.
class Lattice {
 public:
  void cover(double value) {
    if (value != 0) unit_ = std::min(unit_, odd_parts(value).exponent);
  }
  void cover(std::span<const Vec3> points) {
    for (const Vec3& p : points)
      for (const double x : p) cover(x);
  }
  WideInteger at(double value) const {
    if (value == 0) return 0;
    const OddParts parts = odd_parts(value);
    WideInteger result = parts.mantissa;
    return result *= WideInteger(1) << (parts.exponent - unit_);
  }
  std::vector<WidePoint> at(std::span<const Vec3> points) const {
    std::vector<WidePoint> result;
    result.reserve(points.size());
    for (const Vec3& p : points) result.push_back({at(p[0]), at(p[1]), at(p[2])});
    return result;
  }

 private:
  int unit_ = std::numeric_limits<int>::max();
};

/// The vertex with the smallest projection, and the projection.
std::pair<int, WideInteger> min(const std::vector<WidePoint>& points, const WidePoint& axis) {
  std::pair<int, WideInteger> best{0, dot(axis, points[0])};
  for (std::size_t i = 1; i < points.size(); ++i)
    if (WideInteger p = dot(axis, points[i]); p < best.second) best = {static_cast<int>(i), std::move(p)};
  return best;
}

}  // namespace

// Each iteration either decides, or replaces the simplex by one that is nearer to the origin; there are finitely many
// simplices. An iteration decides if no point of the hull of differences is nearer: then the smallest projection is
// that of the nearest point itself, which is the origin, within `distance`, or further away.
bool hulls_in_integers(std::span<const Vec3> a, std::span<const Vec3> b, double distance, const HullStart& start) {
  Lattice lattice;
  lattice.cover(a);
  lattice.cover(b);
  lattice.cover(distance);
  const std::vector<WidePoint> own = lattice.at(a), other = lattice.at(b);
  const WideInteger limit = lattice.at(distance), limit_square = limit * limit;
  WideSimplex simplex;
  const auto add = [&](std::pair<int, int> name) {
    const WidePoint& to = other[static_cast<std::size_t>(name.second)];
    const WidePoint& from = own[static_cast<std::size_t>(name.first)];
    simplex.add(WidePoint(to - from), name);
  };
  add({0, 0});
  for (int i = 0; i < start.size; ++i)
    if (simplex.size < 4) add(start.names[static_cast<std::size_t>(i)]);
  for (;;) {
    if (simplex.square <= limit_square * simplex.divisor) return true;
    const WidePoint axis = simplex.direction, back = -axis;
    const auto [j, low_other] = min(other, axis);
    const auto [i, low_own] = min(own, back);
    const WideInteger gap = low_other + low_own;
    if (gap > 0 && gap * gap > limit_square * dot(axis, axis)) return false;
    add({i, j});
  }
}

}  // namespace volccd::detail
