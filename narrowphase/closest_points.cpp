#include <volccd/narrowphase/closest_points.hpp>

#include <Eigen/Geometry>

namespace volccd::detail {
namespace {

/// Keeps the nearer one of `best` and the points with these weights; `best` if they are equal.
void offer(FeatureKind kind, const Differences& d, const std::array<double, 4>& weights, ClosestPoints& best) {
  ClosestPoints c;
  c.weights = weights;
  c.separation = separation_of(kind, d, weights);
  c.squared_distance = c.separation.squaredNorm();
  if (c.squared_distance < best.squared_distance) best = c;
}

/// Parameter s of the point of the segment a + s (b - a) that is closest to p.
double closest_parameter(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 e = b - a;
  const double length = e.squaredNorm();
  return length > 0 ? std::clamp(e.dot(p - a) / length, 0.0, 1.0) : 0.0;
}

void offer_triangle_inside(const Differences& d, ClosestPoints& best) {
  const Vec3 e1 = d[1] - d[0], e2 = d[2] - d[0], n = e1.cross(e2);
  const double area = n.squaredNorm();
  if (!(area > 0)) return;
  // The second iteration corrects the error of the first: for slivers, n loses digits.
  double w1 = 0, w2 = 0;
  for (int round = 0; round < 2; ++round) {
    const Vec3 q = -(d[0] + w1 * e1 + w2 * e2);
    w1 += n.dot(q.cross(e2)) / area;
    w2 += n.dot(e1.cross(q)) / area;
  }
  const double w0 = 1 - w1 - w2;
  if (w0 >= 0 && w1 >= 0 && w2 >= 0) offer(FeatureKind::vf, d, {1, w0, w1, w2}, best);
}

void offer_crossing_edges(const Differences& d, ClosestPoints& best) {
  const Vec3 &e1 = d[0], e2 = d[2] - d[1], n = e1.cross(e2);
  const double area = n.squaredNorm();
  if (!(area > 0)) return;
  double s = 0, u = 0;
  for (int round = 0; round < 2; ++round) {
    const Vec3 q = d[1] + u * e2 - s * e1;
    s += n.dot(q.cross(e2)) / area;
    u += n.dot(q.cross(e1)) / area;
  }
  if (s >= 0 && s <= 1 && u >= 0 && u <= 1) offer(FeatureKind::ee, d, {1 - s, s, 1 - u, u}, best);
}

/// v without its component along e. Two iterations are sufficient: the second corrects the cancellation error of the
/// first.
Vec3 across(Vec3 v, const Vec3& e) {
  const double length = e.squaredNorm();
  if (!(length > 0)) return v;
  for (int round = 0; round < 2; ++round) v -= (v.dot(e) / length) * e;
  return v;
}

}  // namespace

ClosestPoints closest_points(FeatureKind kind, const Differences& d) {
  ClosestPoints best;
  best.squared_distance = std::numeric_limits<double>::infinity();
  const Vec3 origin = Vec3::Zero();
  if (kind == FeatureKind::vf) {
    offer_triangle_inside(d, best);
    double s = closest_parameter(origin, d[0], d[1]);
    offer(kind, d, {1, 1 - s, s, 0}, best);
    s = closest_parameter(origin, d[1], d[2]);
    offer(kind, d, {1, 0, 1 - s, s}, best);
    s = closest_parameter(origin, d[0], d[2]);
    offer(kind, d, {1, 1 - s, 0, s}, best);
    return best;
  }
  offer_crossing_edges(d, best);
  double s = closest_parameter(origin, d[1], d[2]);
  offer(kind, d, {1, 0, 1 - s, s}, best);
  s = closest_parameter(d[0], d[1], d[2]);
  offer(kind, d, {0, 1, 1 - s, s}, best);
  s = closest_parameter(d[1], origin, d[0]);
  offer(kind, d, {1 - s, s, 1, 0}, best);
  s = closest_parameter(d[2], origin, d[0]);
  offer(kind, d, {1 - s, s, 0, 1}, best);
  return best;
}

bool clearly_apart(FeatureKind kind, const Differences& d, double distance, double size) {
  const bool vf = kind == FeatureKind::vf;
  const Vec3 e1 = vf ? Vec3(d[1] - d[0]) : d[0], e2 = vf ? Vec3(d[2] - d[0]) : Vec3(d[2] - d[1]);
  const Vec3 q = vf ? Vec3(-d[0]) : d[1];
  const Vec3 n = e1.cross(e2), m1 = q.cross(e2), m2 = vf ? e1.cross(q) : q.cross(e1);
  const double area = n.squaredNorm(), c1 = n.dot(m1), c2 = n.dot(m2);
  // Each of these values divided by |n| |edge| is a signed distance in the projection along n: by how much one feature
  // is on the inner side of a line that has the other feature on it or behind it. |edge| < 4 size; the sum of the
  // magnitudes exceeds |n|; and the rounding error of a cross product of vectors shorter than 2 size is less than 32
  // units of roundoff times size^2.
  const double min = vf ? std::min({c1, c2, area - c1 - c2}) : std::min({c1, area - c1, c2, area - c2});
  const double n1 = n.lpNorm<1>(), m = m1.lpNorm<1>() + m2.lpNorm<1>();
  const double rounding = 64 * kUnitRoundoff * (n1 + m) * size * size;
  return min < -(n1 * 4 * size * distance + 2 * rounding);
}

Vec3 separating_axis(FeatureKind kind, const Differences& d, const ClosestPoints& closest) {
  const std::array<double, 4>& w = closest.weights;
  if (kind == FeatureKind::vf) {
    const Vec3 e01 = d[1] - d[0], e02 = d[2] - d[0], e12 = d[2] - d[1];
    if (w[1] > 0 && w[2] > 0 && w[3] > 0) return across(across(Vec3(e01.cross(e02)), e01), e02);
    if (w[1] > 0 && w[2] > 0) return across(closest.separation, e01);
    if (w[1] > 0 && w[3] > 0) return across(closest.separation, e02);
    if (w[2] > 0 && w[3] > 0) return across(closest.separation, e12);
    return closest.separation;
  }
  const Vec3 &first = d[0], second = d[2] - d[1];
  const bool in_first = w[0] > 0 && w[1] > 0, in_second = w[2] > 0 && w[3] > 0;
  if (in_first && in_second) {
    const Vec3 n = first.cross(second);
    // Parallel edges: any direction perpendicular to both is suitable.
    return n.squaredNorm() > 0x1p-60 * first.squaredNorm() * second.squaredNorm() ? across(across(n, first), second)
                                                                                  : across(closest.separation, first);
  }
  if (in_first) return across(closest.separation, first);
  if (in_second) return across(closest.separation, second);
  return closest.separation;
}

std::array<Vec3, 5> close_axes(FeatureKind kind, const Differences& d, const Vec3& separation) {
  const bool vf = kind == FeatureKind::vf;
  const Vec3 first = vf ? Vec3(d[1] - d[0]) : d[0], second = d[2] - (vf ? d[0] : d[1]);
  return {separation, across(separation, first), across(separation, second),
          vf ? across(separation, d[2] - d[1]) : across(across(separation, first), second),
          across(across(first.cross(second), first), second)};
}

}  // namespace volccd::detail
