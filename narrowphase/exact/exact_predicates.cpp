#include <volccd/narrowphase/exact/exact_predicates.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include <volccd/narrowphase/exact/detail/exact_approach.hpp>
#include <volccd/narrowphase/exact/detail/exact_geometry.hpp>
#include <volccd/narrowphase/exact/detail/first_time.hpp>
#include <volccd/numerics/odd_parts.hpp>

namespace volccd {
namespace {

using namespace detail;

/// Whether, along the x, y or z axis, one feature is beyond the other by more than the separation at each control
/// point, and therefore at all times. Exact, because a rounded difference exceeds a double only if the difference does.
bool axis_separates(const TestMotion& motion, double separation) {
  const int split = motion.kind == FeatureKind::vf ? 1 : 2;
  for (int k = 0; k < 3; ++k) {
    bool below = true, above = true;
    for (int c = 0; c < motion.control_points; ++c)
      for (int i = 0; i < split; ++i)
        for (int j = split; j < 4; ++j) {
          const double a = motion.points[static_cast<std::size_t>(i)][3 * c + k];
          const double b = motion.points[static_cast<std::size_t>(j)][3 * c + k];
          below = below && b - a > separation;
          above = above && a - b > separation;
        }
    if (below || above) return true;
  }
  return false;
}

[[maybe_unused]] bool valid(const TestMotion& motion) {
  if (motion.control_points != 2 && motion.control_points != 3) return false;
  return std::all_of(motion.points.begin(), motion.points.end(), [&](const double* x) {
    return std::all_of(x, x + 3 * motion.control_points, [](double v) { return std::isfinite(v); });
  });
}

class FirstTouch {
 public:
  FirstTouch(const TestMotion& motion, double t_max)
      : kind_(motion.kind), x_(relative_curves(motion).x), volume_(dot(x_[1], cross(x_[2], x_[3]))), first_(t_max) {
    first_.answer.degenerate = volume_.is_zero();
  }

  ExactAnswer find() {
    AlgebraicTime start(Dyadic{0, 0});
    if (start.sign(volume_) == 0 && test_touch_at(start)) {
      first_.keep_start();
      first_.answer.side = start.sign_before(volume_);
      return first_.answer;
    }
    const auto touches = [&](AlgebraicTime& t) { return test_touch_at(t); };
    if (volume_.is_zero()) {
      for (const Polynomial& event : coplanar_events(kind_, x_))
        if (auto t = first_.first_root(event, touches)) first_.keep_earlier(*t, TouchCase::coplanar);
    } else if (auto t = first_.first_root(volume_, touches)) {
      const int side = t->sign_before(volume_);
      first_.keep_earlier(*t, side == t->sign_after(volume_) ? TouchCase::grazing : TouchCase::crossing);
      first_.answer.side = side;
    }
    return first_.answer;
  }

 private:
  bool test_touch_at(AlgebraicTime& t) {
    bool degenerate = false;
    const bool touches = coplanar_features_touch(kind_, x_, t, degenerate);
    first_.answer.degenerate = first_.answer.degenerate || (touches && degenerate);
    return touches;
  }

  FeatureKind kind_;
  std::array<Curve, 4> x_;
  Polynomial volume_;  ///< six times the volume of the tetrahedron of the points
  FirstTime first_;
};

}  // namespace

int coordinate_bits(const TestMotion& motion, double separation) {
  int min = std::numeric_limits<int>::max(), greatest = std::numeric_limits<int>::min();
  const auto include = [&](double x) {
    if (x == 0) return;
    min = std::min(min, odd_parts(x).exponent);
    greatest = std::max(greatest, std::ilogb(x) + 1);
  };
  include(separation);
  for (const double* x : motion.points) std::for_each(x, x + 3 * motion.control_points, include);
  return min > greatest ? 0 : greatest - min;
}

ExactAnswer exact_first_touch(const TestMotion& motion, double t_max, double separation) {
  assert(valid(motion) && t_max >= 0 && t_max <= 1 && separation >= 0 && std::isfinite(separation));
  if (axis_separates(motion, separation)) return {};
  return separation > 0 ? first_approach(motion, separation, t_max) : FirstTouch(motion, t_max).find();
}

}  // namespace volccd
