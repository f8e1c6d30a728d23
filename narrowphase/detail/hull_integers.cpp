#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include <boost/multiprecision/cpp_int.hpp>

#include <volccd/narrowphase/detail/hull_overlap.hpp>
#include <volccd/narrowphase/detail/hull_simplex.hpp>

namespace volccd::detail {

namespace {

/// Of any size; up to 768 bits (coordinates of some 60 bits over their common unit) it allocates nothing.
using Integer =
    boost::multiprecision::number<boost::multiprecision::cpp_int_backend<768, 0>, boost::multiprecision::et_off>;
using Simplex = HullSimplex<Integer>;
using Point = Vector3<Integer>;

/// value = mantissa 2^exponent, the mantissa odd or 0.
struct Parts {
  std::int64_t mantissa;
  int exponent;
};

Parts parts_of(double value) {
  if (value == 0) return {0, std::numeric_limits<int>::max()};
  int exponent = 0;
  const auto mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(value, &exponent), 53));
  const int zeros = std::countr_zero(static_cast<std::uint64_t>(mantissa));
  return {mantissa / (std::int64_t{1} << zeros), exponent - 53 + zeros};
}

/// Coordinates as integer multiples of a power of two.
class Lattice {
 public:
  void cover(double value) { unit_ = std::min(unit_, parts_of(value).exponent); }
  void cover(std::span<const Vec3> points) {
    for (const Vec3& p : points)
      for (const double x : p) cover(x);
  }
  Integer at(double value) const {
    const Parts parts = parts_of(value);
    if (parts.mantissa == 0) return 0;
    Integer result = parts.mantissa;
    return result *= Integer(1) << (parts.exponent - unit_);
  }
  std::vector<Point> at(std::span<const Vec3> points) const {
    std::vector<Point> result;
    result.reserve(points.size());
    for (const Vec3& p : points) result.push_back({at(p[0]), at(p[1]), at(p[2])});
    return result;
  }

 private:
  int unit_ = std::numeric_limits<int>::max();
};

/// The vertex of least projection, and the projection.
std::pair<int, Integer> least(const std::vector<Point>& points, const Point& axis) {
  std::pair<int, Integer> best{0, dot(axis, points[0])};
  for (std::size_t i = 1; i < points.size(); ++i)
    if (Integer p = dot(axis, points[i]); p < best.second) best = {static_cast<int>(i), std::move(p)};
  return best;
}

}  // namespace

// Each turn either decides or brings the simplex nearer to the origin; there are finitely many simplices. It does
// decide when no point of the hull of differences is nearer: then the least projection is that of the nearest point
// itself, which is the origin, close enough, or further away than `distance`.
bool hulls_in_integers(std::span<const Vec3> a, std::span<const Vec3> b, double distance, const HullStart& start) {
  Lattice lattice;
  lattice.cover(a);
  lattice.cover(b);
  lattice.cover(distance);
  const std::vector<Point> own = lattice.at(a), other = lattice.at(b);
  const Integer limit = lattice.at(distance), limit_square = limit * limit;
  Simplex simplex;
  const auto add = [&](std::pair<int, int> name) {
    simplex.add(Point(other[static_cast<std::size_t>(name.second)] - own[static_cast<std::size_t>(name.first)]), name);
  };
  add({0, 0});
  for (int i = 0; i < start.size; ++i)
    if (simplex.size < 4) add(start.names[static_cast<std::size_t>(i)]);
  for (;;) {
    if (simplex.square <= limit_square * simplex.divisor) return true;
    const Point axis = simplex.direction, back{Integer(-axis.x), Integer(-axis.y), Integer(-axis.z)};
    const auto [j, low_other] = least(other, axis);
    const auto [i, low_own] = least(own, back);
    const Integer gap = low_other + low_own;
    if (gap > 0 && gap * gap > limit_square * dot(axis, axis)) return false;
    add({i, j});
  }
}

}  // namespace volccd::detail
