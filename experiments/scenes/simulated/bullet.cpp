#include <volccd/experiments/scenes/simulated/bullet.hpp>

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include <volccd/core/error.hpp>
#include <volccd/core/random.hpp>
#include <volccd/experiments/scenes/geometry/hexahedral_solids.hpp>

namespace volccd {

namespace {

constexpr double kBulletSpeed = 750, kBulletGap = 0.0004;

simulation::Material copper() {
  simulation::Material m;
  m.density = 8940;
  m.youngs_modulus = 117e9;
  m.poisson_ratio = 0.34;
  m.yield_stress = 300e6;
  m.hardening_modulus = 300e6;
  m.rate_factor = 0.025;
  m.failure_strain = 2;
  m.breaking_strain = 2;
  m.friction = 0.1;
  return m;
}

simulation::Material steel() {
  simulation::Material m;
  m.density = 7850;
  m.youngs_modulus = 205e9;
  m.poisson_ratio = 0.29;
  m.yield_stress = 400e6;
  m.hardening_modulus = 600e6;
  m.rate_factor = 0.015;
  m.failure_strain = 0.8;
  m.breaking_strain = 0.8;
  m.friction = 0.1;
  return m;
}

BulletShape bullet_shape(double finer) {
  BulletShape bullet;
  const auto scaled = [&](int n, int min) { return std::max(min, static_cast<int>(std::lround(n * finer))); };
  bullet.core = scaled(bullet.core, 2);
  bullet.rings = scaled(bullet.rings, 1);
  bullet.layers = scaled(bullet.layers, 6);
  return bullet;
}

/// Among plates that are nearly square, the one whose number of elements is nearest to `elements`.
PlateShape plate_shape(int elements, double finer) {
  PlateShape plate;
  plate.cells[2] = std::max(2, static_cast<int>(std::lround(plate.cells[2] * finer)));
  const double across = std::sqrt(static_cast<double>(elements) / plate.cells[2]);
  plate.cells[0] = std::max(6, static_cast<int>(std::lround(across)));
  plate.cells[1] =
      std::max(6, static_cast<int>(std::lround(static_cast<double>(elements) / plate.cells[2] / plate.cells[0])));
  return plate;
}

/// Moves vertices inside the plate, so that cracks do not prefer the lines of the grid.
void roughen(Shape& shape, const PlateShape& plate, Random& random) {
  const Vec3 cell(plate.fine / (plate.cells[0] * 0.667), plate.fine / (plate.cells[1] * 0.667),
                  plate.thickness / plate.cells[2]);
  const double rim = plate.side / 2 * (1 - 1e-9), inset = plate.thickness * 1e-9;
  for (Vec3& p : shape.positions) {
    const Vec3 by = 0.04 * cell.cwiseProduct(Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)));
    if (std::abs(p.x()) > rim || std::abs(p.y()) > rim || p.z() > -inset || p.z() < inset - plate.thickness) continue;
    p += by;
  }
}

}  // namespace

simulation::Model bullet_model(int elements, std::uint64_t seed) {
  if (elements < 500 || elements > 10'000'000) throw ConfigError("bullet: elements is not in 500 .. 10000000");
  Random random(seed);
  const double finer = std::cbrt(static_cast<double>(elements) / kBulletElements);
  const BulletShape bullet = bullet_shape(finer);
  const PlateShape plate = plate_shape(elements - bullet.elements(), finer);
  Shape shot = round_nosed_bullet(bullet), target = graded_plate(plate);
  const double turn = random.uniform(-3.14, 3.14), yaw = random.uniform(0.005, 0.015);
  const Eigen::Matrix3d tilt = Eigen::AngleAxisd(yaw, Vec3(std::cos(turn), std::sin(turn), 0)).toRotationMatrix();
  double lowest = 1;
  for (Vec3& p : shot.positions) lowest = std::min(lowest, (p = tilt * p).z());
  shot.translate(Vec3(random.uniform(-2e-4, 2e-4), random.uniform(-2e-4, 2e-4), kBulletGap - lowest));
  roughen(target, plate, random);

  Shape all;
  all.append(shot, 0).append(target, 1);
  simulation::Model model;
  model.mesh = all.mesh();
  model.positions = all.positions;
  model.velocities.assign(all.positions.size(), Vec3::Zero());
  std::fill_n(model.velocities.begin(), shot.positions.size(), Vec3(0, 0, -kBulletSpeed));
  model.bodies = {{"bullet", copper(), 0, false}, {"plate", steel(), 0, false}};
  const double rim = plate.side / 2 * (1 - 1e-9);
  for (std::size_t v = shot.positions.size(); v < all.positions.size(); ++v)
    if (std::abs(all.positions[v].x()) > rim || std::abs(all.positions[v].y()) > rim)
      model.fixed.push_back(static_cast<Index>(v));
  return model;
}

}  // namespace volccd
