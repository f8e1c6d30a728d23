#include <volccd/narrowphase/detail/contact_frame.hpp>

#include <Eigen/Geometry>

namespace volccd::detail {
namespace {

/// How long before the contact a separation is looked at, and below what share of the size it says nothing.
constexpr double kBefore = 0x1p-12, kLeastSeparation = 0x1p-40, kLeastArea = 0x1p-48;

Vec3 position(const double* x, double t) {
  const double s = 1 - t;
  return {s * x[0] + t * x[3], s * x[1] + t * x[4], s * x[2] + t * x[5]};
}

}  // namespace

Vec3 contact_normal(FeatureKind kind, const MovingPoints& points, double t, int side) {
  const Differences d = points.at(t);
  if (side != 0) {
    const Vec3 n = kind == FeatureKind::vf ? Vec3((d[1] - d[0]).cross(d[2] - d[0])) : Vec3(d[0].cross(d[2] - d[1]));
    const double length = n.norm();
    if (length > kLeastArea * points.size * points.size) {
      const bool along = (kind == FeatureKind::ee) == (side > 0);
      return (along ? n : Vec3(-n)) / length;
    }
  }
  const Vec3 apart = closest_points(kind, points.at(t - kBefore)).separation;
  const double length = apart.norm();
  return length > kLeastSeparation * points.size ? Vec3(apart / length) : Vec3(Vec3::Zero());
}

Vec3 contact_point(FeatureKind kind, const TestPoints& x, double t, const std::array<double, 4>& weights) {
  Vec3 point = Vec3::Zero();
  for (std::size_t i = kind == FeatureKind::vf ? 1 : 2; i < 4; ++i) point += weights[i] * position(x[i], t);
  return point;
}

}  // namespace volccd::detail
