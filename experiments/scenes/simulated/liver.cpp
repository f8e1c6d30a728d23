#include <volccd/experiments/scenes/simulated/liver.hpp>

#include <Eigen/Geometry>

#include <volccd/core/error.hpp>
#include <volccd/core/random.hpp>
#include <volccd/experiments/scenes/geometry/liver.hpp>
#include <volccd/experiments/scenes/geometry/tetrahedra.hpp>

namespace volccd {

namespace {

constexpr double kTurn = 0.17;                                               // of the lattice, radians at most
constexpr double kLeftHold = -0.09, kRightHold = 0.065, kLowestHold = 0.03;  // what is held: beyond, and above
constexpr double kSag = 0.2;                                                 // s before the cut

/// The liver filled by a lattice that is turned by `turn`.
Shape turned_liver(int elements, const Eigen::Matrix3d& turn) {
  const ImplicitSolid liver = liver_solid();
  ImplicitSolid turned;
  turned.value = [&](const Vec3& p) { return liver.value(turn * p); };
  // The box of the turned box.
  const Vec3 middle = turn.transpose() * ((liver.low + liver.high) / 2);
  const Vec3 half = turn.transpose().cwiseAbs() * ((liver.high - liver.low) / 2);
  turned.low = middle - half;
  turned.high = middle + half;
  Shape shape = fill_with_about(turned, elements);
  for (Vec3& p : shape.positions) p = turn * p;
  return shape;
}

simulation::Cut cut_from_below() {
  simulation::Cut cut;
  cut.point = Vec3(-0.01, 0, -0.1);
  // Askew, so that it does not follow the lattice that the mesh was made from.
  cut.normal = Vec3(0.92, 0.25, 0.3).normalized();
  cut.direction = cut.normal.cross(Vec3::UnitY()).normalized();
  cut.begin = kSag;
  cut.length = 0.143;
  cut.speed = 0.3;
  return cut;
}

}  // namespace

simulation::Model liver_model(int elements, std::uint64_t seed) {
  if (elements < 300 || elements > 10'000'000) throw ConfigError("liver: elements must be in 300 .. 10000000");
  Random random(hash_ids(seed, 0x11fe4));
  Vec3 axis;
  for (int c = 0; c < 3; ++c) axis[c] = random.uniform(-1, 1);
  const Shape shape =
      turned_liver(elements, Eigen::AngleAxisd(random.uniform(-kTurn, kTurn), axis.normalized()).toRotationMatrix());

  simulation::Model model;
  model.mesh = shape.mesh();
  model.positions = shape.positions;
  model.velocities.assign(shape.positions.size(), Vec3::Zero());
  simulation::Part part;
  part.name = "liver";
  part.material.density = 1060;
  part.material.youngs_modulus = 7e3;
  part.material.poisson_ratio = 0.4;
  part.material.friction = 0.1;
  part.material.damping = 3;
  model.parts.push_back(part);
  for (Index v = 0; v < model.positions.size(); ++v) {
    const Vec3& p = model.positions[v];
    if (p.z() > kLowestHold && (p.x() < kLeftHold || p.x() > kRightHold)) model.fixed.push_back(v);
  }
  model.cuts.push_back(cut_from_below());
  model.gravity = Vec3(0, 0, -9.81);
  return model;
}

}  // namespace volccd
