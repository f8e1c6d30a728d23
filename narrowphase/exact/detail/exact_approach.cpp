#include <volccd/narrowphase/exact/detail/exact_approach.hpp>

#include <volccd/narrowphase/exact/detail/exact_geometry.hpp>
#include <volccd/narrowphase/exact/detail/first_time.hpp>

namespace volccd::detail {

namespace {

Polynomial square(const Curve& v) { return dot(v, v); }

bool not_negative(AlgebraicTime& t, const Polynomial& p) { return t.sign(p) >= 0; }

class FirstApproach {
 public:
  FirstApproach(const TestMotion& motion, double separation, double t_max)
      : curves_(relative_curves(motion, separation)),
        x_(curves_.x),
        limit_(Polynomial({curves_.separation * curves_.separation})),
        first_(t_max) {}

  ExactAnswer find(FeatureKind kind) {
    const bool vf = kind == FeatureKind::vf;
    for (std::size_t i = 0; i < (vf ? 1u : 2u); ++i)
      for (std::size_t j = vf ? 1 : 2; j < 4; ++j) add_points(x_[j] - x_[i]);
    for (const PointAndEdge& p : points_and_edges(kind))
      add_point_and_edge(x_[p.g] - x_[p.point], x_[p.h] - x_[p.point]);
    vf ? add_vertex_and_triangle() : add_edges();
    return first_.answer;
  }

 private:
  /// Adds the first root of `event` at which the distance is that of two points in the insides of these parts.
  template <class Inside>
  void add(const Polynomial& event, Inside&& inside) {
    if (event.is_zero()) return;
    if (auto t = first_.first_root(event, inside)) first_.keep_earlier(*t, TouchCase::approach);
  }

  void add_points(const Curve& apart) {
    add(square(apart) - limit_, [](AlgebraicTime&) { return true; });
  }

  /// g and h: from the point to the ends of the edge.
  void add_point_and_edge(const Curve& g, const Curve& h) {
    const Curve edge = h - g;
    const Polynomial length = square(edge);
    add(square(cross(g, edge)) - limit_ * length, [&](AlgebraicTime& t) {
      return t.sign(length) > 0 && t.sign(dot(g, edge)) <= 0 && not_negative(t, dot(h, edge));
    });
  }

  void add_vertex_and_triangle() {
    const Curve normal = cross(x_[2] - x_[1], x_[3] - x_[1]);
    const Polynomial height = dot(normal, x_[1]), area = square(normal);
    const auto inside = [&](AlgebraicTime& t, std::size_t a, std::size_t b) {
      return not_negative(t, dot(normal, cross(x_[a], x_[b])));
    };
    add(height * height - limit_ * area,
        [&](AlgebraicTime& t) { return t.sign(area) > 0 && inside(t, 1, 2) && inside(t, 2, 3) && inside(t, 3, 1); });
  }

  void add_edges() {
    const Curve u = x_[1], v = x_[3] - x_[2], r = x_[2], normal = cross(u, v);
    const Polynomial height = dot(normal, r), area = square(normal);
    const auto between = [&](AlgebraicTime& t, const Polynomial& at) {
      return not_negative(t, at) && not_negative(t, area - at);
    };
    add(height * height - limit_ * area, [&](AlgebraicTime& t) {
      return t.sign(area) > 0 && between(t, dot(normal, cross(r, v))) && between(t, dot(normal, cross(r, u)));
    });
  }

  RelativeCurves curves_;
  const std::array<Curve, 4>& x_;
  Polynomial limit_;  ///< the square of the separation
  FirstTime first_;
};

}  // namespace

ExactAnswer first_approach(const TestMotion& motion, double separation, double t_max) {
  if (compare_distance(motion, 0, separation) > 0) return FirstApproach(motion, separation, t_max).find(motion.kind);
  FirstTime first(t_max);
  first.keep_start();
  return first.answer;
}

}  // namespace volccd::detail
