#include <volccd/experiments/scenes/geometry/liver.hpp>

namespace volccd {

ImplicitSolid liver_solid() {
  ImplicitSolid solid;
  solid.low = Vec3(-0.15, -0.09, -0.1);
  solid.high = Vec3(0.13, 0.08, 0.1);
  solid.value = [](const Vec3& p) {
    // A dome that is flatter towards the left lobe; its lower left part is cut off.
    const Vec3 flattened(p.x(), p.y() * (1 + 6 * std::clamp(p.x() + 0.05, 0.0, 0.2)), p.z());
    const double dome = ellipsoid(flattened, {-0.015, 0, 0}, {0.125, 0.066, 0.085});
    const double below = Vec3(0.45, 0.2, -0.87).normalized().dot(p - Vec3(0, 0, -0.045));
    const double wedge = smooth_difference(dome, -below, 0.025);
    // The solid is hollow behind and below, so that the lower edge is sharp, and has a notch between the lobes.
    const double hollow = ellipsoid(p, {0.03, 0.105, -0.06}, {0.13, 0.09, 0.09});
    const double notch = ellipsoid(p, {0.035, -0.02, -0.05}, {0.009, 0.05, 0.035});
    return smooth_difference(smooth_difference(wedge, hollow, 0.02), notch, 0.012);
  };
  return solid;
}

}  // namespace volccd
