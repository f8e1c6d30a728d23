#include <volccd/experiments/scenes/simulated/weld.hpp>

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include <volccd/core/error.hpp>
#include <volccd/core/random.hpp>
#include <volccd/oracle/cases/shapes.hpp>

namespace volccd {

namespace {

// Sizes of the target, 16 x 16 x 4 mm; the flyer has three quarters of its width and half of its thickness.
constexpr double kTargetSide = 0.016, kTargetThickness = 0.004, kVolume = 1312e-9;
constexpr double kSpeed = 300, kGap = 0.0001;
constexpr double kMergingDistance = 0.12;  // in edges; it is small because merging moves vertices, which costs energy
constexpr double kMergingStress = 50e6;    // the merging force is this stress times the area of a cell's face

simulation::Material aluminium(double edge) {
  simulation::Material m;
  m.density = 2700;
  m.youngs_modulus = 70e9;
  m.poisson_ratio = 0.33;
  m.yield_stress = 280e6;
  m.hardening_modulus = 400e6;
  m.failure_stress = 600e6;
  m.merging_force = kMergingStress * edge * edge;
  m.merging_distance = kMergingDistance * edge;
  m.friction = 0.2;
  return m;
}

/// A plate of across x across x layers cubes, centred in x and y; its top is at z = 0.
Shape plate(int across, int layers, double edge) {
  Shape shape = block(ElementType::hexahedron, across, across, layers);
  for (Vec3& p : shape.positions) p = edge * (p - Vec3(0.5 * across, 0.5 * across, layers));
  return shape;
}

}  // namespace

simulation::Model weld_model(int elements, std::uint64_t seed) {
  if (elements < 300 || elements > 1'000'000) throw ConfigError("weld: elements is not in 300 .. 1000000");
  Random random(seed);
  const double edge = std::cbrt(kVolume / elements);
  const auto cells = [&](double length) { return static_cast<int>(std::lround(length / edge)); };
  const int rim = cells(kTargetSide / 8), layers = cells(kTargetThickness / 2);
  const int across = cells(kTargetSide);
  Shape flyer = plate(across - 2 * rim, layers, edge);
  const Shape target = plate(across, 2 * layers, edge);
  const double turn = random.uniform(0.002, 0.01), tilt = random.uniform(0.002, 0.01),
               about = random.uniform(-3.14, 3.14);
  const Eigen::Matrix3d place =
      (Eigen::AngleAxisd(tilt, Vec3(std::cos(about), std::sin(about), 0)) * Eigen::AngleAxisd(turn, Vec3::UnitZ()))
          .toRotationMatrix();
  double lowest = 1;
  for (Vec3& p : flyer.positions) lowest = std::min(lowest, (p = place * p).z());
  flyer.translate(Vec3(0, 0, kGap - lowest));

  Shape all;
  all.append(flyer, 0).append(target, 1);
  simulation::Model model;
  model.mesh = all.mesh();
  model.positions = all.positions;
  model.velocities.assign(all.positions.size(), Vec3::Zero());
  std::fill_n(model.velocities.begin(), flyer.positions.size(), Vec3(0, 0, -kSpeed));
  model.bodies = {{"flyer", aluminium(edge), 0, false}, {"target", aluminium(edge), 0, false}};
  return model;
}

}  // namespace volccd
