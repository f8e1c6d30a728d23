#include <volccd/narrowphase/exact/exact_predicates.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <volccd/narrowphase/exact/detail/exact_geometry.hpp>
#include <volccd/numerics/odd_parts.hpp>

namespace volccd {
namespace {

using namespace detail;

/// Whether, along the x, y or z axis, one feature is beyond the other at each control point, and therefore at all
/// times. Comparisons of doubles are exact.
bool axis_separates(const TestMotion& motion) {
  const int split = motion.kind == FeatureKind::vf ? 1 : 2;
  for (int k = 0; k < 3; ++k) {
    bool below = true, above = true;
    for (int c = 0; c < motion.control_points; ++c)
      for (int i = 0; i < split; ++i)
        for (int j = split; j < 4; ++j) {
          const double a = motion.points[static_cast<std::size_t>(i)][3 * c + k];
          const double b = motion.points[static_cast<std::size_t>(j)][3 * c + k];
          below = below && a < b;
          above = above && a > b;
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
      : kind_(motion.kind), t_max_(t_max), x_(relative_curves(motion)), volume_(dot(x_[1], cross(x_[2], x_[3]))) {
    answer_.degenerate = volume_.is_zero();
  }

  ExactAnswer find() {
    AlgebraicTime start(Dyadic{0, 0});
    if (start.sign(volume_) == 0 && test_touch_at(start)) {
      answer_.reason = TouchCase::at_start;
      answer_.side = start.sign_before(volume_);
      answer_.touches = answer_.toi_exact = true;
      return answer_;
    }
    if (volume_.is_zero()) {
      for (const Polynomial& event : coplanar_events(kind_, x_))
        if (auto t = first_touching_root(event, latest())) keep_earlier(*t);
    } else if (auto t = first_touching_root(volume_, t_max_)) {
      answer_.side = t->sign_before(volume_);
      answer_.reason = answer_.side == t->sign_after(volume_) ? TouchCase::grazing : TouchCase::crossing;
      keep(*t);
    }
    return answer_;
  }

 private:
  bool test_touch_at(AlgebraicTime& t) {
    bool degenerate = false;
    const bool touches = coplanar_features_touch(kind_, x_, t, degenerate);
    answer_.degenerate = answer_.degenerate || (touches && degenerate);
    return touches;
  }

  /// Later times need not be examined: as doubles, none of them is earlier than the contact that is already known.
  double latest() const { return answer_.touches ? std::min(t_max_, std::nextafter(answer_.toi, 1.0)) : t_max_; }

  /// The first of the roots in (0, latest] at which the features touch.
  std::optional<AlgebraicTime> first_touching_root(const Polynomial& p, double latest) {
    for (AlgebraicTime& t : roots_in_step(p)) {
      if (t.compare(dyadic(latest)) > 0) break;
      if (test_touch_at(t)) return std::move(t);
    }
    return std::nullopt;
  }

  void keep(AlgebraicTime& t) {
    answer_.touches = true;
    answer_.toi = t.floor();
    // A time of the form n / 2^k is known exactly, and may nevertheless have too many bits for a double.
    answer_.toi_exact = t.compare(dyadic(answer_.toi)) == 0;
  }

  /// Among times with the same largest double below, a time that is equal to this double is the earliest.
  void keep_earlier(AlgebraicTime& t) {
    const ExactAnswer last = answer_;
    answer_.reason = TouchCase::coplanar;
    keep(t);
    if (last.touches && (last.toi < answer_.toi || (last.toi == answer_.toi && last.toi_exact))) answer_ = last;
  }

  FeatureKind kind_;
  double t_max_;
  std::array<Curve, 4> x_;
  Polynomial volume_;  ///< six times the volume of the tetrahedron of the points
  ExactAnswer answer_;
};

}  // namespace

int coordinate_bits(const TestMotion& motion) {
  int min = std::numeric_limits<int>::max(), greatest = std::numeric_limits<int>::min();
  for (const double* x : motion.points)
    for (int i = 0; i < 3 * motion.control_points; ++i) {
      if (x[i] == 0) continue;
      min = std::min(min, odd_parts(x[i]).exponent);
      greatest = std::max(greatest, std::ilogb(x[i]) + 1);
    }
  return min > greatest ? 0 : greatest - min;
}

ExactAnswer exact_first_touch(const TestMotion& motion, double t_max) {
  assert(valid(motion) && t_max >= 0 && t_max <= 1);
  if (axis_separates(motion)) return {};
  return FirstTouch(motion, t_max).find();
}

}  // namespace volccd
