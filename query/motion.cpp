#include <volccd/query/motion.hpp>

#include <string>

#include <volccd/core/error.hpp>

namespace volccd {

namespace {

void check_positions(std::span<const Vec3> x, std::size_t expected, const char* dataset) {
  if (x.size() != expected)
    throw InputError("motion", dataset,
                     "has " + std::to_string(x.size()) + " positions, expected " + std::to_string(expected));
  for (std::size_t i = 0; i < x.size(); ++i)
    if (!x[i].allFinite()) throw InputError("motion", dataset, static_cast<std::int64_t>(i), "not a finite position");
}

}  // namespace

Motion::Motion(Index vertices, int control_points)
    : vertices_(vertices), control_points_(control_points), data_(vertices * stride(), 0.0) {}

Motion Motion::linear(std::span<const Vec3> x0, std::span<const Vec3> x1) {
  Motion motion;
  motion.set_linear(x0, x1);
  return motion;
}

void Motion::set_linear(std::span<const Vec3> x0, std::span<const Vec3> x1) {
  check_positions(x0, x0.size(), "x0");
  check_positions(x1, x0.size(), "x1");
  vertices_ = static_cast<Index>(x0.size());
  control_points_ = 2;
  data_.resize(x0.size() * 6);
  for (Index v = 0; v < vertices_; ++v) {
    set(v, 0, x0[v]);
    set(v, 1, x1[v]);
  }
}

Motion Motion::quadratic(std::span<const Vec3> x0, std::span<const Vec3> xm, std::span<const Vec3> x1) {
  Motion motion;
  motion.set_quadratic(x0, xm, x1);
  return motion;
}

void Motion::set_quadratic(std::span<const Vec3> x0, std::span<const Vec3> xm, std::span<const Vec3> x1) {
  check_positions(x0, x0.size(), "x0");
  check_positions(xm, x0.size(), "xm");
  check_positions(x1, x0.size(), "x1");
  vertices_ = static_cast<Index>(x0.size());
  control_points_ = 3;
  data_.resize(x0.size() * 9);
  for (Index v = 0; v < vertices_; ++v) {
    set(v, 0, x0[v]);
    set(v, 1, xm[v]);
    set(v, 2, x1[v]);
  }
}

void Motion::set_part(const Motion& whole, double begin, double end) {
  vertices_ = whole.vertices_;
  control_points_ = whole.control_points_;
  data_.resize(whole.data_.size());
  const auto between = [](const Vec3& a, const Vec3& b, double t) -> Vec3 { return (1 - t) * a + t * b; };
  for (Index v = 0; v < vertices_; ++v) {
    set(v, 0, whole.position(v, begin));
    if (control_points_ == 3)  // the blossom at (begin, end)
      set(v, 1,
          between(between(whole.point(v, 0), whole.point(v, 1), begin),
                  between(whole.point(v, 1), whole.point(v, 2), begin), end));
    set(v, control_points_ - 1, whole.position(v, end));
  }
}

Vec3 Motion::position(Index v, double t) const {
  if (t == 0) return point(v, 0);
  if (t == 1) return point(v, control_points_ - 1);
  const auto between = [t](const Vec3& a, const Vec3& b) -> Vec3 { return (1 - t) * a + t * b; };
  const Vec3 first = between(point(v, 0), point(v, 1));
  return control_points_ == 2 ? first : between(first, between(point(v, 1), point(v, 2)));
}

}  // namespace volccd
