#include <volccd/simulation/ledger.hpp>

#include <cassert>

#include <Eigen/Geometry>

namespace volccd::simulation {

double kinetic_energy(std::span<const double> mass, std::span<const Vec3> v) {
  assert(mass.size() == v.size());
  double sum = 0;
  for (std::size_t i = 0; i < v.size(); ++i) sum += mass[i] * v[i].squaredNorm();
  return sum / 2;
}

Vec3 momentum(std::span<const double> mass, std::span<const Vec3> v) {
  assert(mass.size() == v.size());
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < v.size(); ++i) sum += mass[i] * v[i];
  return sum;
}

Vec3 angular_momentum(std::span<const double> mass, std::span<const Vec3> x, std::span<const Vec3> v) {
  assert(mass.size() == v.size() && x.size() == v.size());
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < v.size(); ++i) sum += mass[i] * x[i].cross(v[i]);
  return sum;
}

double total(std::span<const double> mass) {
  double sum = 0;
  for (double m : mass) sum += m;
  return sum;
}

}  // namespace volccd::simulation
