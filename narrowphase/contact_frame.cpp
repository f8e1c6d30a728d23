#include <volccd/narrowphase/contact_frame.hpp>

#include <cmath>

#include <Eigen/Geometry>

namespace volccd::detail {
namespace {

/// A separation is not significant below kMinSeparation times the size, and an area below kMinArea times the
/// squared size.
constexpr double kMinSeparation = 0x1p-40, kMinArea = 0x1p-48;

Vec3 position(const double* x, double t, int control_points) {
  const double s = 1 - t;
  const Vec3 first(s * x[0] + t * x[3], s * x[1] + t * x[4], s * x[2] + t * x[5]);
  if (control_points == 2) return first;
  const Vec3 second(s * x[3] + t * x[6], s * x[4] + t * x[7], s * x[5] + t * x[8]);
  return s * first + t * second;
}

/// A direction of unit length, or zero if it is too short to be determined.
Vec3 direction(const Vec3& apart, double size) {
  const double length = apart.norm();
  return length > kMinSeparation * size ? Vec3(apart / length) : Vec3(Vec3::Zero());
}

/// Calls use(points, scale) for the differences of the points, scaled if they are not of ordinary size.
template <class Use>
auto with_points(const TestPoints& x, int control_points, Use&& use) {
  const auto scaled = [&](const auto& differences) {
    double scale = 1;
    auto points = differences(x, scale);
    if (!(points.size >= kMinSize && points.size <= kGreatestSize))
      points = differences(x, scale = range_scale(x, control_points));
    return use(points, scale);
  };
  return control_points == 2 ? scaled(moving_points) : scaled(curved_points);
}

}  // namespace

Vec3 contact_normal(FeatureKind kind, const Differences& touching, const Differences& before, double size, int side) {
  if (side != 0) {
    const Differences& d = touching;
    const Vec3 n = kind == FeatureKind::vf ? Vec3((d[1] - d[0]).cross(d[2] - d[0])) : Vec3(d[0].cross(d[2] - d[1]));
    const double length = n.norm();
    if (length > kMinArea * size * size) {
      const bool along = (kind == FeatureKind::ee) == (side > 0);
      return (along ? n : Vec3(-n)) / length;
    }
  }
  return direction(closest_points(kind, before).separation, size);
}

Vec3 contact_point(FeatureKind kind, const TestPoints& x, double t, const std::array<double, 4>& weights,
                   int control_points) {
  Vec3 point = Vec3::Zero();
  for (std::size_t i = kind == FeatureKind::vf ? 1 : 2; i < 4; ++i)
    point += weights[i] * position(x[i], t, control_points);
  return point;
}

Contact contact_at(FeatureKind kind, const std::array<Index, 4>& vertices, const TestPoints& x, int control_points,
                   double t, int side, double separation) {
  return with_points(x, control_points, [&](const auto& points, double scale) {
    const Differences d = points.at(t);
    Contact contact = contact_near(kind, vertices, x, control_points, t, {closest_points(kind, d), points.size, scale});
    const bool apart = separation > 0;
    if (!apart || side != 0)
      contact.normal = contact_normal(kind, d, apart ? d : points.at(t - kBefore), points.size, side);
    return contact;
  });
}

Contact contact_near(FeatureKind kind, const std::array<Index, 4>& vertices, const TestPoints& x, int control_points,
                     double t, const ScaledClosestPoints& closest) {
  Contact contact;
  contact.kind = kind;
  contact.vertices = vertices;
  contact.toi = t;
  contact.normal = direction(closest.points.separation, closest.size);
  contact.weights = closest.points.weights;
  contact.gap = std::sqrt(closest.points.squared_distance) / closest.scale;
  contact.point = contact_point(kind, x, t, contact.weights, control_points);
  return contact;
}

ContactEnd contact_end(FeatureKind kind, const TestPoints& x, int control_points) {
  ContactEnd end;
  with_points(x, control_points, [&](const auto& points, double scale) {
    const ClosestPoints closest = closest_points(kind, points.at(1));
    end.gap = std::sqrt(closest.squared_distance) / scale;
    end.weights = closest.weights;
    return 0;
  });
  end.first.setZero();
  for (std::size_t i = 0; i < (kind == FeatureKind::vf ? 1u : 2u); ++i)
    end.first += end.weights[i] * position(x[i], 1, control_points);
  end.second = contact_point(kind, x, 1, end.weights, control_points);
  return end;
}

}  // namespace volccd::detail
