#include <volccd/experiments/scenes/simulated/liver.hpp>

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include <volccd/core/error.hpp>
#include <volccd/core/random.hpp>
#include <volccd/experiments/scenes/geometry/liver.hpp>
#include <volccd/experiments/scenes/geometry/tetrahedra.hpp>
#include <volccd/experiments/scenes/geometry/tools.hpp>

namespace volccd {

namespace {

constexpr double kTurn = 0.17;                                               // of the lattice, radians at most
constexpr double kLeftHold = -0.09, kRightHold = 0.065, kLowestHold = 0.03;  // what is held: beyond, and above
constexpr double kSag = 0.35;                                                // s before the cut
/// How the liver has sagged when it is cut, measured: along the direction of the cut, along its normal at the cut's
/// origin, and the change of the latter with the depth. The scalpel comes along the plane that has sagged in this way.
constexpr double kSagAlong = -0.017, kSagAcross = -0.0235, kSagTilt = 0.11;
constexpr double kLiverEdge = 0.0145;  // of the default size, about
/// How far the scalpel's edge is behind that of the cut, in edges of the liver: it does not push at what is not cut
/// yet, which would crush elements.
constexpr double kBehind = 1.5;

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
  cut.speed = 0.25;
  return cut;
}

double edge_of(int elements) { return kLiverEdge * std::cbrt(static_cast<double>(kLiverElements) / elements); }

/// Cells about as large as those of a liver of this many elements.
KnifeShape scalpel_shape(int elements) {
  KnifeShape scalpel{.width = 0.16, .height = 0.12, .thickness = 0.003, .bevel = 0.015};
  const double edge = edge_of(elements);
  scalpel.along = std::max(2, static_cast<int>(std::lround(scalpel.width / edge)));
  scalpel.down = std::max(2, 1 + static_cast<int>(std::lround((scalpel.height - scalpel.bevel) / edge)));
  return scalpel;
}

/// Appends a scalpel that goes with the cut through the liver as it has sagged.
void add_scalpel(simulation::Model& model, Shape& all, int elements, const simulation::Cut& cut) {
  const Shape tool = knife(scalpel_shape(elements));
  const auto object = static_cast<std::int32_t>(model.bodies.size());
  const Vec3 along = (cut.direction + kSagTilt * cut.normal).normalized();
  const Vec3 across = cut.normal - cut.normal.dot(along) * along;
  Eigen::Matrix3d axes;
  axes << across.normalized().cross(along), across.normalized(), along;
  const Vec3 start = cut.point + kSagAcross * cut.normal + (kSagAlong - kBehind * edge_of(elements)) * cut.direction;
  all.append(tool, object);
  for (const Vec3& p : tool.positions) model.positions.push_back(axes * p + start);
  simulation::Body body{"scalpel", {}, 0, true};
  body.material.friction = 0.05;
  model.bodies.push_back(body);
  const double end = cut.begin + cut.length / cut.speed;
  model.guides.push_back({object, {{cut.begin, Vec3::Zero()}, {end, cut.length * along}}});
}

}  // namespace

simulation::Model liver_model(int elements, std::uint64_t seed) {
  if (elements < 300 || elements > 10'000'000) throw ConfigError("liver: elements must be in 300 .. 10000000");
  Random random(hash_ids(seed, 0x11fe4));
  Vec3 axis;
  for (int c = 0; c < 3; ++c) axis[c] = random.uniform(-1, 1);
  const Shape shape =
      turned_liver(elements - scalpel_shape(elements).elements(),
                   Eigen::AngleAxisd(random.uniform(-kTurn, kTurn), axis.normalized()).toRotationMatrix());

  simulation::Model model;
  model.positions = shape.positions;
  simulation::Body body;
  body.name = "liver";
  body.material.density = 1060;
  body.material.youngs_modulus = 7e3;
  body.material.poisson_ratio = 0.4;
  body.material.friction = 0.1;
  body.material.damping = 10;
  model.bodies.push_back(body);
  for (Index v = 0; v < model.positions.size(); ++v) {
    const Vec3& p = model.positions[v];
    if (p.z() > kLowestHold && (p.x() < kLeftHold || p.x() > kRightHold)) model.fixed.push_back(v);
  }
  model.cuts.push_back(cut_from_below());
  Shape all = shape;
  add_scalpel(model, all, elements, model.cuts[0]);
  model.mesh = all.mesh();
  model.velocities.assign(model.positions.size(), Vec3::Zero());
  model.gravity = Vec3(0, 0, -9.81);
  return model;
}

}  // namespace volccd
