#include <volccd/narrowphase/cubic/detail/coplanar_events.hpp>

#include <cassert>

#include <Eigen/Geometry>

#include <volccd/narrowphase/cubic/detail/polynomial_roots.hpp>
#include <volccd/numerics/rounding.hpp>

namespace volccd::detail {
namespace {

/// Maximum number of times to examine: lo, 4 triples x 3 axes x (2 roots, extremum), 6 pairs x 3 axes.
constexpr std::size_t kMaxEvents = 1 + 4 * 3 * 3 + 6 * 3;

class Events {
 public:
  Events(double lo, double hi, double slack) : lo_(lo), hi_(hi), slack_(slack) { times_[count_++] = lo; }

  void add(double t) {
    if (!(t >= lo_ - slack_ && t <= hi_ + slack_)) return;
    assert(count_ < kMaxEvents);
    times_[count_++] = std::clamp(t, lo_, hi_);
  }

  /// Adds the roots of q0 s^2 + q1 s t + q2 t^2, and the extremum, in case rounding made a double root complex or
  /// inaccurate.
  void add_quadratic(double q0, double q1, double q2) {
    std::array<double, 2> roots;
    const int count = quadratic_roots(q0, 0.5 * q1, q2, roots);
    for (int i = 0; i < count; ++i) add(roots[static_cast<std::size_t>(i)]);
    add((q0 - 0.5 * q1) / (q0 - q1 + q2));
  }

  /// The times in ascending order.
  const double* begin() const { return times_.data(); }
  const double* end() const { return times_.data() + count_; }
  void sort() { std::sort(times_.begin(), times_.begin() + static_cast<std::ptrdiff_t>(count_)); }

 private:
  double lo_, hi_, slack_;
  std::array<double, kMaxEvents> times_;
  std::size_t count_ = 0;
};

void add_collinear(const Vec3& a0, const Vec3& b0, const Vec3& a1, const Vec3& b1, Events& events) {
  const Vec3 q0 = a0.cross(b0), q1 = a0.cross(b1) + a1.cross(b0), q2 = a1.cross(b1);
  for (int k = 0; k < 3; ++k) events.add_quadratic(q0[k], q1[k], q2[k]);
}

void add_meeting(const Vec3& start, const Vec3& end, Events& events) {
  for (int k = 0; k < 3; ++k) events.add(start[k] / (start[k] - end[k]));
}

void add_events(FeatureKind kind, const MovingPoints& points, Events& events) {
  const Differences &x0 = points.start, &x1 = points.end;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    add_collinear(x0[i], x0[j], x1[i], x1[j], events);
    add_meeting(x0[i], x1[i], events);
    add_meeting(x0[j] - x0[i], x1[j] - x1[i], events);
  }
  // No contact begins when the corners of the triangle itself become collinear.
  if (kind == FeatureKind::ee) add_collinear(x0[1] - x0[0], x0[2] - x0[0], x1[1] - x1[0], x1[2] - x1[0], events);
}

}  // namespace

std::optional<Touch> first_coplanar_touch(FeatureKind kind, const MovingPoints& points, double lo, double hi,
                                          double distance, double slack) {
  Events events(lo, hi, slack);
  if (points.travel > 0) add_events(kind, points, events);
  events.sort();
  double last = -1;
  for (const double t : events) {
    if (t == last) continue;
    last = t;
    const Differences d = points.at(t);
    if (clearly_apart(kind, d, distance, points.size)) continue;
    const ClosestPoints closest = closest_points(kind, d);
    if (closest.squared_distance <= distance * distance) return Touch{t, closest};
  }
  return std::nullopt;
}

bool centroid_axis_separates(FeatureKind kind, const MovingPoints& points, double distance) {
  const Differences d = points.at(0.5);
  const bool vf = kind == FeatureKind::vf;
  const Vec3 axis = vf ? Vec3(d[0] + d[1] + d[2]) : Vec3(d[1] + d[2] - d[0]);
  double gap = std::numeric_limits<double>::infinity();
  for (const Differences& x : {points.start, points.end}) {
    const double g0 = axis.dot(x[0]), g1 = axis.dot(x[1]), g2 = axis.dot(x[2]);
    gap = std::min(gap, vf ? std::min({g0, g1, g2}) : std::min(g1, g2) - std::max(0.0, g0));
  }
  const double length = axis.lpNorm<1>();
  return gap > length * (distance + 2 * gap_error_factor(0) * points.size);
}

}  // namespace volccd::detail
