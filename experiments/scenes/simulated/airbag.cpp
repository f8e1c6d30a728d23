#include <volccd/experiments/scenes/simulated/airbag.hpp>

#include <algorithm>
#include <cmath>

#include <volccd/core/error.hpp>
#include <volccd/core/random.hpp>
#include <volccd/experiments/scenes/geometry/folded_airbag.hpp>
#include <volccd/experiments/scenes/geometry/steering_wheel.hpp>

namespace volccd {

namespace {

constexpr double kWheelTop = -0.006;    // distance of the wheel below the middle surface of the bag
constexpr double kInletRadius = 0.045;  // radius within which the bag is fixed to the hub

simulation::Material fabric() {
  simulation::Material m;
  m.density = 720;
  m.youngs_modulus = 3e8;
  m.poisson_ratio = 0.3;
  m.friction = 0.1;
  m.damping = 20;
  return m;
}

}  // namespace

simulation::Model airbag_model(int elements, std::uint64_t seed) {
  if (elements < 1'200 || elements > 10'000'000) throw ConfigError("airbag: elements is not in 1200 .. 10000000");
  const AirbagShape airbag;
  const int for_wheel = std::max(330, static_cast<int>(std::lround(0.15 * elements)));
  const Shape bag = folded_airbag_of(airbag, elements - for_wheel);
  Shape wheel = steering_wheel(std::max(330, elements - static_cast<int>(bag.elements.size())));
  wheel.translate(Vec3(0, 0, kWheelTop - 0.014));

  simulation::Model model;
  Shape all = bag;
  all.append(wheel, 2);
  for (std::size_t e = 0; e < bag.elements.size(); ++e) all.elements[e] = bag.elements[e];
  model.mesh = all.mesh();
  model.positions = all.positions;
  model.bodies = {{"bag, side of the wheel", fabric(), 0.00035, false},
                  {"bag, side of the driver", fabric(), 0.00035, false},
                  {"steering wheel", {}, 0.001, true}};
  model.bodies[2].material.density = 1500;
  model.bodies[2].material.friction = 0.1;

  Random random(seed);
  model.velocities.assign(all.positions.size(), Vec3::Zero());
  for (std::size_t v = 0; v < bag.positions.size(); ++v)
    for (int k = 0; k < 3; ++k) model.velocities[v][k] = random.uniform(-0.2, 0.2);
  for (Index v = 0; v < all.positions.size(); ++v) {
    const Vec3& p = all.positions[v];
    const bool inlet = v < bag.positions.size() && p.z() < 0 && std::hypot(p.x(), p.y()) < kInletRadius;
    if (!inlet && v < bag.positions.size()) continue;
    model.fixed.push_back(v);
    model.velocities[v].setZero();
  }
  // The gas enters with a pressure pulse, which closes the folds.
  const std::vector<std::pair<double, double>> curve{{0, 6000}, {1e-3, 3000}, {8e-3, 4000}, {20e-3, 8000}};
  model.pressures = {{0, curve}, {1, curve}};
  return model;
}

}  // namespace volccd
