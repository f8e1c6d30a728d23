#include <volccd/experiments/scenes/geometry/octopus.hpp>

#include <array>
#include <limits>
#include <numbers>
#include <vector>

#include <volccd/core/random.hpp>

namespace volccd {

namespace {

constexpr int kTentacles = 8, kPieces = 14;
// distance of the tentacles from the axis, and their radii at the root and at the tip
constexpr double kRing = 0.026, kRoot = 0.019, kTip = 0.007;
constexpr double kLength = 0.2;
constexpr double kBlend = 0.016;

/// Balls along a line, whose radius decreases from piece to piece.
struct Tentacle {
  std::array<Vec3, kPieces + 1> spine;
  std::array<double, kPieces + 1> radius;
  Vec3 centre = Vec3::Zero();
  double reach = 0;  ///< radius of a ball around `centre` that contains the tentacle

  Tentacle(int number, const OctopusPose& pose, Random& random) {
    const double length = kLength * random.uniform(0.9, 1.12), droop = pose.droop + random.uniform(-0.15, 0.15);
    const double sway = random.uniform(-0.7, 0.7), curl = random.uniform(2.2, 3.6), lean = random.uniform(-0.25, 0.25);
    const double azimuth = 2 * std::numbers::pi * (number + 0.5 + random.uniform(-0.08, 0.08)) / kTentacles;
    const Vec3 out(std::cos(azimuth), std::sin(azimuth), 0), side(-out.y(), out.x(), 0);
    Vec3 p = kRing * out;
    for (std::size_t i = 0; i <= kPieces; ++i) {
      const double s = static_cast<double>(i) / kPieces;
      spine[i] = p;
      radius[i] = std::max(kRoot + (kTip - kRoot) * std::pow(s, 0.8), pose.thinnest);
      // The second half of a tentacle is rolled up. Its heading lies in a plane through the axis of the octopus; this
      // plane turns sideways along the tentacle.
      const double middle = s + 0.5 / kPieces, pitch = -droop + curl * std::pow(middle, 2.6),
                   turn = sway * middle + lean;
      const Vec3 heading = std::cos(turn) * out + std::sin(turn) * side;
      p += length / kPieces * (std::cos(pitch) * heading + std::sin(pitch) * Vec3::UnitZ());
    }
    for (const Vec3& q : spine) centre += q / (kPieces + 1);
    for (std::size_t i = 0; i <= kPieces; ++i) reach = std::max(reach, (spine[i] - centre).norm() + radius[i]);
  }

  double distance(const Vec3& p) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < kPieces; ++i) {
      const Vec3 piece = spine[i + 1] - spine[i], to = p - spine[i];
      const double share = std::clamp(to.dot(piece) / piece.squaredNorm(), 0.0, 1.0);
      nearest = std::min(nearest, (to - share * piece).norm() - radius[i] - share * (radius[i + 1] - radius[i]));
    }
    return nearest;
  }
};

double body(const Vec3& p) {
  const double mantle = ellipsoid(p, {-0.012, 0, 0.075}, {0.046, 0.044, 0.058});
  const double neck = ellipsoid(p, {0, 0, 0.012}, {0.038, 0.038, 0.03});
  const Vec3 mirrored(p.x(), std::abs(p.y()), p.z());
  const double eye = ellipsoid(mirrored, {0.026, 0.026, 0.045}, Vec3::Constant(0.015));
  return smooth_union(smooth_union(mantle, neck, 0.03), eye, 0.006);
}

}  // namespace

ImplicitSolid octopus_solid(const OctopusPose& pose) {
  Random random(hash_ids(pose.seed, 0x0c70));
  std::vector<Tentacle> tentacles;
  for (int i = 0; i < kTentacles; ++i) tentacles.emplace_back(i, pose, random);
  ImplicitSolid solid;
  solid.low = Vec3(-0.06, -0.06, -0.03);
  solid.high = Vec3(0.06, 0.06, 0.14);
  for (const Tentacle& t : tentacles)
    for (std::size_t i = 0; i <= kPieces; ++i) {
      // Each blend enlarges the solid by up to a quarter of its size.
      const Vec3 radius = Vec3::Constant(t.radius[i] + kBlend);
      solid.low = solid.low.cwiseMin(t.spine[i] - radius);
      solid.high = solid.high.cwiseMax(t.spine[i] + radius);
    }
  solid.value = [tentacles](const Vec3& p) {
    double value = body(p);
    for (const Tentacle& t : tentacles) {
      if ((p - t.centre).norm() - t.reach < value + kBlend) value = smooth_union(value, t.distance(p), kBlend);
    }
    return value;
  };
  return solid;
}

}  // namespace volccd
