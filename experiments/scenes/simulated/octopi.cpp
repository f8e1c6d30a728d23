#include <volccd/experiments/scenes/simulated/octopi.hpp>

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include <volccd/core/error.hpp>
#include <volccd/core/random.hpp>
#include <volccd/experiments/scenes/geometry/octopus.hpp>
#include <volccd/experiments/scenes/geometry/tetrahedra.hpp>
#include <volccd/experiments/scenes/geometry/tools.hpp>

namespace volccd {

namespace {

constexpr int kOctopi = 3;
constexpr double kOctopiSpeed = 1.0, kOctopiTurning = 4;  // m/s towards the middle, rad/s
constexpr double kFunnelSlope = 0.85;                     // radians from the horizontal
constexpr double kFunnelShare = 0.18;                     // of all elements

/// Where an octopus is: its own z axis points away from the middle of the scene, its origin is `distance` from there.
struct Octopus {
  ImplicitSolid solid;
  Shape shape;
  double edge = 0;
  Eigen::Matrix3d axes;

  Vec3 outwards() const { return axes.col(2); }
  Vec3 placed(const Vec3& p, double distance) const { return axes * p + distance * outwards(); }
  /// Whether a point of the scene is about nearer to its surface than `gap`, or inside.
  bool is_near(const Vec3& p, double distance, double gap) const {
    const Vec3 own = axes.transpose() * (p - distance * outwards());
    const bool in_box = ((own - solid.low).array() > -gap).all() && ((solid.high - own).array() > -gap).all();
    return in_box && solid.value(own) < gap;
  }
};

Octopus make_octopus(int number, int elements, Random& random) {
  Octopus octopus;
  OctopusPose pose;
  pose.seed = random.next();
  pose.droop = 0.75;
  // Half the edge length that this number of elements will have, about: what the mesh can hold on to.
  pose.thinnest = std::max(0.007, 0.0086 * std::pow(5866.0 / elements, 0.52));
  octopus.solid = octopus_solid(pose);
  octopus.shape = fill_with_about(octopus.solid, elements, &octopus.edge);
  const double azimuth = 2 * std::numbers::pi * number / kOctopi + random.uniform(-0.15, 0.15);
  const double lift = random.uniform(0.05, 0.3), spin = random.uniform(0, 2 * std::numbers::pi);
  octopus.axes =
      (Eigen::AngleAxisd(azimuth, Vec3::UnitZ()) * Eigen::AngleAxisd(std::numbers::pi / 2 - lift, Vec3::UnitY()) *
       Eigen::AngleAxisd(spin, Vec3::UnitZ()))
          .toRotationMatrix();
  return octopus;
}

/// Whether all vertices of each are at least `gap` outside the others.
bool apart(const std::vector<Octopus>& octopi, double distance, double gap) {
  for (const Octopus& a : octopi)
    for (const Octopus& b : octopi)
      if (&a != &b)
        for (const Vec3& p : a.shape.positions)
          if (b.is_near(a.placed(p, distance), distance, gap)) return false;
  return true;
}

/// How near to the middle they get when they come from afar together.
double first_touch(const std::vector<Octopus>& octopi) {
  double gap = 0;
  for (const Octopus& octopus : octopi) gap = std::max(gap, octopus.edge);
  double distance = 0.5;
  while (distance > 0.01 && apart(octopi, distance - 0.01, gap)) distance -= 0.01;
  return distance;
}

/// Its walls are beyond all vertices by `gap`.
FunnelShape funnel_around(const std::vector<Vec3>& positions, double gap, int rings) {
  FunnelShape shape;
  shape.slope = kFunnelSlope;
  shape.rings = rings;
  double nearest = 0;
  for (int i = 0; i < 6; ++i) {
    const double azimuth = std::numbers::pi * i / 3;
    const Vec3 normal(std::sin(kFunnelSlope) * std::cos(azimuth), std::sin(kFunnelSlope) * std::sin(azimuth),
                      std::cos(kFunnelSlope));
    for (const Vec3& p : positions) nearest = std::min(nearest, normal.dot(p));
  }
  shape.depth = gap - nearest;
  shape.thickness = 0.6 * shape.depth / rings;
  return shape;
}

/// Appends the funnel as a body that does not move.
void add_funnel(simulation::Model& model, Shape& all, const FunnelShape& shape) {
  const Shape tool = funnel(shape);
  all.append(tool, static_cast<std::int32_t>(model.bodies.size()));
  for (const Vec3& p : tool.positions) {
    model.fixed.push_back(static_cast<Index>(model.positions.size()));
    model.positions.push_back(p);
  }
  model.velocities.resize(model.positions.size(), Vec3::Zero());
  simulation::Body body{"funnel", {}, 0, true};
  body.material.friction = 0.2;
  model.bodies.push_back(body);
}

}  // namespace

simulation::Model octopi_model(int elements, std::uint64_t seed) {
  if (elements < 1'500 || elements > 10'000'000) throw ConfigError("octopi: elements must be in 1500 .. 10000000");
  Random random(hash_ids(seed, 0x0c70b1));
  std::vector<Octopus> octopi;
  const int rings = static_cast<int>(std::lround(std::sqrt(kFunnelShare * elements / 18)));
  int left = elements - FunnelShape{.rings = rings}.elements();
  for (int i = 0; i < kOctopi; ++i) {
    octopi.push_back(make_octopus(i, left / (kOctopi - i), random));
    left -= static_cast<int>(octopi.back().shape.elements.size());
  }

  simulation::Model model;
  Shape all;
  const double distance = first_touch(octopi);
  for (int i = 0; i < kOctopi; ++i) {
    const Octopus& octopus = octopi[static_cast<std::size_t>(i)];
    all.append(octopus.shape, i);
    const Vec3 turning =
        kOctopiTurning * random.uniform(0.7, 1.3) * (random.next() % 2 == 0 ? 1 : -1) * octopus.outwards();
    for (const Vec3& p : octopus.shape.positions) {
      model.positions.push_back(octopus.placed(p, distance));
      model.velocities.push_back(-kOctopiSpeed * octopus.outwards() + turning.cross(model.positions.back()));
    }
    simulation::Body body;
    body.name = "octopus " + std::to_string(i + 1);
    body.material.density = 1000;
    body.material.youngs_modulus = 5e4;
    body.material.poisson_ratio = 0.4;
    body.material.friction = 0.4;
    body.material.damping = 4;
    model.bodies.push_back(body);
  }
  add_funnel(model, all, funnel_around(model.positions, octopi.front().edge / 2, rings));
  model.mesh = all.mesh();
  model.gravity = Vec3(0, 0, -9.81);
  return model;
}

}  // namespace volccd
