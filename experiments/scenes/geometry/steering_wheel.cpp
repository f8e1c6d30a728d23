#include <volccd/experiments/scenes/geometry/steering_wheel.hpp>

#include <array>
#include <cmath>
#include <numbers>

#include <volccd/experiments/scenes/geometry/quad_complex.hpp>

namespace volccd {

namespace {

// radius of the torus to the middle of the tube, and of the tube
constexpr double kRimRadius = 0.186, kRimThickness = 0.014;
constexpr double kHubRadius = 0.060, kHubCore = 0.034;
constexpr double kHubTop = 0.010, kHubBottom = -0.030;
constexpr int kAlongRim = 12, kAround = 6;
enum Part : std::int32_t { kRimPart, kHubPart, kSpokesPart, kCapsPart };

/// Angle at which each station begins, in degrees. The spokes start from the narrow stations: to the right, to the
/// left, and down.
constexpr std::array<double, kAlongRim> kBegin{-7, 7, 40.2, 73.4, 106.6, 139.8, 173, 187, 225, 263, 277, 315};
constexpr bool has_spoke(int station) { return station == 0 || station == 6 || station == 9; }

Vec3 polar(double radius, int station, double z) {
  const double angle = kBegin[static_cast<std::size_t>(station % kAlongRim)] * std::numbers::pi / 180;
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

Vec3 onto_rim(const Vec3& p) {
  const double r = std::hypot(p.x(), p.y());
  const Vec3 middle(p.x() / r * kRimRadius, p.y() / r * kRimRadius, 0);
  return middle + (p - middle).normalized() * kRimThickness;
}

Vec3 onto_cylinder(const Vec3& p) {
  const double scale = kHubRadius / std::hypot(p.x(), p.y());
  return {p.x() * scale, p.y() * scale, p.z()};
}

/// Corner k of the rim at a station. The side between k = 2 and k = 3 faces the hub.
Vec3 rim_corner(int station, int k) {
  const double angle = 2 * std::numbers::pi * (k + 0.5) / kAround;
  return polar(kRimRadius + kRimThickness * std::cos(angle), station, kRimThickness * std::sin(angle));
}

Vec3 hub_corner(int station, int level) {
  constexpr std::array<double, 4> kLevels{kHubBottom, -0.016, -0.002, kHubTop};
  return polar(kHubRadius, station, kLevels[static_cast<std::size_t>(level)]);
}

void add_rim(QuadComplex& wheel) {
  for (int s = 0; s < kAlongRim; ++s)
    for (int k = 0; k < kAround; ++k)
      if (k != 2 || !has_spoke(s))
        wheel.patch(kRimPart, rim_corner(s, k), rim_corner(s + 1, k), rim_corner(s + 1, (k + 1) % kAround),
                    rim_corner(s, (k + 1) % kAround));
}

void add_hub(QuadComplex& wheel) {
  for (int s = 0; s < kAlongRim; ++s)
    for (int level = 0; level < 3; ++level)
      if (level != 1 || !has_spoke(s))
        wheel.patch(kHubPart, hub_corner(s, level), hub_corner(s + 1, level), hub_corner(s + 1, level + 1),
                    hub_corner(s, level + 1));
}

/// A hexagonal core of three patches, and a ring between the core and the side of the drum.
void add_cap(QuadComplex& wheel, int level) {
  const double z = level == 0 ? kHubBottom : kHubTop;
  const auto inner = [&](int s) { return polar(kHubCore, s, z); };
  const auto patch = [&](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    level == 0 ? wheel.patch(kCapsPart, a, d, c, b) : wheel.patch(kCapsPart, a, b, c, d);
  };
  const Vec3 middle(0, 0, z);
  for (int s = 0; s < kAlongRim; ++s) patch(inner(s), hub_corner(s, level), hub_corner(s + 1, level), inner(s + 1));
  for (int s = 0; s < kAlongRim; s += 2) patch(middle, inner(s), inner(s + 1), inner(s + 2));
}

void add_spokes(QuadComplex& wheel) {
  for (int s = 0; s < kAlongRim; ++s) {
    if (!has_spoke(s)) continue;
    // Both loops are counter-clockwise as seen from the rim, so that normals point out of the spoke.
    wheel.tube(kSpokesPart, {{hub_corner(s, 1), hub_corner(s + 1, 1), hub_corner(s + 1, 2), hub_corner(s, 2)},
                             {rim_corner(s, 3), rim_corner(s + 1, 3), rim_corner(s + 1, 2), rim_corner(s, 2)}});
  }
}

}  // namespace

Shape steering_wheel(int triangles) {
  QuadComplex wheel;
  wheel.snap(kRimPart, onto_rim);
  wheel.snap(kHubPart, onto_cylinder);
  add_rim(wheel);
  add_hub(wheel);
  add_cap(wheel, 0);
  add_cap(wheel, 3);
  add_spokes(wheel);
  Shape shape = wheel.mesh(wheel.spacing_for(triangles));
  for (ElementSpec& element : shape.elements) element.object = 0;
  return shape;
}

}  // namespace volccd
