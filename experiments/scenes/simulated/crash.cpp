#include <volccd/experiments/scenes/simulated/crash.hpp>

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include <volccd/core/error.hpp>
#include <volccd/core/random.hpp>
#include <volccd/experiments/scenes/geometry/quad_complex.hpp>
#include <volccd/experiments/scenes/geometry/vehicle_front.hpp>

namespace volccd {

namespace {

constexpr double kCrashSpeed = 20, kCrashGap = 0.015;
constexpr double kMassScale = 4;
constexpr double kEngineMass = 140, kRearMass = 320;  // kg
constexpr double kRoughness = 0.01;                   // of the mean edge
/// The wall: half its width, its lower and its upper side, and thickness. No part of the car comes to its rim.
constexpr double kWallReach = 0.95, kWallLow = -0.02, kWallHigh = 1.1, kWallThickness = 0.01;
constexpr double kWallShare = 0.11;  // of all elements, so that they are about as large as those of the car

struct Sheet {
  double thickness;
  simulation::Material material;
};

simulation::Material steel(double yield) {
  simulation::Material m;
  m.density = 7850 * kMassScale;
  m.youngs_modulus = 205e9;
  m.poisson_ratio = 0.3;
  m.yield_stress = yield;
  m.hardening_modulus = 900e6;
  m.rate_factor = 0.02;
  m.friction = 0.2;
  return m;
}

simulation::Material light(double density, double modulus, double yield) {
  simulation::Material m = steel(yield);
  m.density = density * kMassScale;
  m.youngs_modulus = modulus;
  m.hardening_modulus = modulus / 50;
  m.rate_factor = 0;
  return m;
}

Sheet sheet_of(VehiclePart part) {
  switch (part) {
    case VehiclePart::bumper_beam: return {0.0022, steel(420e6)};
    case VehiclePart::crash_boxes: return {0.0017, steel(260e6)};
    case VehiclePart::rails: return {0.0022, steel(340e6)};
    case VehiclePart::cross_members: return {0.0014, steel(260e6)};
    case VehiclePart::radiator: return {0.0015, light(2700, 70e9, 80e6)};
    case VehiclePart::upper_rails: return {0.0014, steel(280e6)};
    case VehiclePart::aprons: return {0.0010, steel(220e6)};
    case VehiclePart::hood: return {0.0009, steel(180e6)};
    case VehiclePart::fenders: return {0.0008, steel(180e6)};
    case VehiclePart::fascia: return {0.0030, light(1100, 2e9, 30e6)};
    case VehiclePart::firewall: return {0.0016, steel(300e6)};
    case VehiclePart::floor: return {0.0016, steel(300e6)};
    case VehiclePart::sides: return {0.0020, steel(350e6)};
    case VehiclePart::windscreen: return {0.0030, light(2500, 70e9, 200e6)};
    case VehiclePart::wheels: return {0.0030, light(2600, 8e8, simulation::kNever)};
    case VehiclePart::engine: return {0.0030, steel(simulation::kNever)};
    case VehiclePart::mounts: return {0.0025, steel(300e6)};
    case VehiclePart::rear: return {0.0020, steel(simulation::kNever)};
  }
  return {};
}

double area_of(const Shape& shape, VehiclePart part) {
  double area = 0;
  for (const ElementSpec& e : shape.elements)
    if (e.object == static_cast<std::int32_t>(part)) {
      const Vec3 &a = shape.positions[e.vertices[0]], &b = shape.positions[e.vertices[1]],
                 &c = shape.positions[e.vertices[2]];
      area += (b - a).cross(c - a).norm() / 2;
    }
  return area;
}

simulation::Body vehicle_part(const Shape& shape, VehiclePart part) {
  const Sheet sheet = sheet_of(part);
  simulation::Body result{to_string(part), sheet.material, sheet.thickness, false};
  if (part == VehiclePart::engine || part == VehiclePart::rear) {
    const double mass = part == VehiclePart::engine ? kEngineMass : kRearMass;
    result.rigid = true;
    result.material.density = mass / (area_of(shape, part) * sheet.thickness);
  }
  return result;
}

/// A sheet whose front side is at x = `front`.
Shape wall_sheet(double front, int triangles) {
  QuadComplex sheet;
  const double x = front - kWallThickness / 2;
  sheet.patch(0, {x, -kWallReach, kWallLow}, {x, kWallReach, kWallLow}, {x, kWallReach, kWallHigh},
              {x, -kWallReach, kWallHigh});
  return sheet.mesh(sheet.spacing_for(triangles));
}

simulation::Body wall_part() {
  simulation::Body body{"wall", {}, kWallThickness, true};
  body.material.friction = 0.3;
  return body;
}

double mean_edge(const Shape& shape) {
  double area = 0;
  for (std::int32_t part = 0; part < kVehicleParts; ++part) area += area_of(shape, static_cast<VehiclePart>(part));
  return std::sqrt(2 * area / static_cast<double>(shape.elements.size()));
}

}  // namespace

simulation::Model crash_model(int elements, std::uint64_t seed) {
  if (elements < 2'000 || elements > 10'000'000) throw ConfigError("crash: elements is not in 2000 .. 10000000");
  Shape shape = vehicle_front(static_cast<int>(std::lround((1 - kWallShare) * elements)));
  simulation::Model model;
  for (std::int32_t part = 0; part < kVehicleParts; ++part)
    model.bodies.push_back(vehicle_part(shape, static_cast<VehiclePart>(part)));
  model.bodies.push_back(wall_part());

  double foremost = 0;
  for (const Vec3& p : shape.positions) foremost = std::min(foremost, p.x());
  const double edge = mean_edge(shape);
  Random random(seed);
  for (Vec3& p : shape.positions)
    for (int k = 0; k < 3; ++k) p[k] += kRoughness * edge * random.uniform(-1, 1);

  model.velocities.assign(shape.positions.size(), Vec3(-kCrashSpeed, 0, 0));
  Shape all = shape;
  all.append(wall_sheet(foremost - kCrashGap, elements - static_cast<int>(shape.elements.size())), kVehicleParts);
  for (std::size_t v = shape.positions.size(); v < all.positions.size(); ++v)
    model.fixed.push_back(static_cast<Index>(v));
  model.velocities.resize(all.positions.size(), Vec3::Zero());
  model.mesh = all.mesh();
  model.positions = std::move(all.positions);
  return model;
}

}  // namespace volccd
