#include <volccd/experiments/simulation/detail/solid_element.hpp>

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include <volccd/experiments/simulation/material.hpp>

namespace volccd::simulation::detail {

namespace {

using Eigen::Matrix3d;

// Below this J nothing is divided by J and nothing flows.
constexpr double kFlat = 0.1;
// Greatest trace of Cp^-1: a thickness of a tenth.
constexpr double kThinnest = 100;
// How far hourglass modes flow, in half edges: beyond, corners would turn inside out.
constexpr double kFarthestMode = 0.5;
constexpr double kLinearViscosity = 0.06, kQuadraticViscosity = 1.44;

// Corners of the reference cube, and the hourglass modes eta zeta, zeta xi, xi eta, xi eta zeta there.
constexpr double kCube[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
constexpr double kModes[4][8] = {{1, 1, -1, -1, -1, -1, 1, 1},
                                 {1, -1, -1, 1, -1, 1, 1, -1},
                                 {1, -1, 1, -1, 1, -1, 1, -1},
                                 {-1, 1, -1, 1, 1, -1, 1, -1}};

Matrix3d full(const Symmetric& s) {
  return (Matrix3d() << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2]).finished();
}

// a b^T where it is symmetric.
Symmetric product(const Matrix3d& a, const Matrix3d& b) {
  const auto row = [&](int i, int j) { return a(i, 0) * b(j, 0) + a(i, 1) * b(j, 1) + a(i, 2) * b(j, 2); };
  return (Symmetric() << row(0, 0), row(1, 1), row(2, 2), row(0, 1), row(1, 2), row(0, 2)).finished();
}

double trace(const Symmetric& s) { return s[0] + s[1] + s[2]; }

Symmetric deviator(Symmetric s) {
  const double mean = trace(s) / 3;
  s[0] -= mean, s[1] -= mean, s[2] -= mean;
  return s;
}

double squared_norm(const Symmetric& s) { return s.head<3>().squaredNorm() + 2 * s.tail<3>().squaredNorm(); }

double determinant(const Symmetric& s) {
  return s[0] * (s[1] * s[2] - s[4] * s[4]) - s[3] * (s[3] * s[2] - s[4] * s[5]) + s[5] * (s[3] * s[4] - s[1] * s[5]);
}

// Not below the greatest eigenvalue, and equal to it if two or three eigenvalues are the same (the two smaller ones).
double greatest_eigenvalue(const Symmetric& s) { return trace(s) / 3 + std::sqrt(2.0 / 3 * squared_norm(deviator(s))); }

struct Kinematics {
  Matrix3d f, cofactor;
  double j;
  double volume_rate;  // dJ/dt
};

Matrix3d cofactor(const Matrix3d& f) {
  Matrix3d c;
  c.col(0) = f.col(1).cross(f.col(2));
  c.col(1) = f.col(2).cross(f.col(0));
  c.col(2) = f.col(0).cross(f.col(1));
  return c;
}

template <int N>
Kinematics kinematics(const SolidShape<N>& shape, std::span<const Vec3> x, std::span<const Vec3> v) {
  Kinematics k;
  Matrix3d rate = Matrix3d::Zero();
  k.f.setZero();
  // From the first corner on: far from the origin, rounding is that of the element's size.
  const Vec3 x0 = x[shape.vertices[0]], v0 = v[shape.vertices[0]];
  for (int i = 1; i < N; ++i) {
    const Vec3 g = shape.gradients[i];
    const Vec3 dx = x[shape.vertices[i]] - x0, dv = v[shape.vertices[i]] - v0;
    k.f.noalias() += dx * g.transpose();
    rate.noalias() += dv * g.transpose();
  }
  k.cofactor = cofactor(k.f);
  k.j = k.f.col(0).dot(k.cofactor.col(0));
  k.volume_rate = (k.cofactor.array() * rate.array()).sum();
  return k;
}

// What be is scaled to by plastic flow: scale times its deviator, and a mean that leaves det be = J^2.
struct Return {
  double scale, mean;
  double dissipated = 0;  // per volume at rest
};

// The root m of det(m I + scale dev) = J^2 from above (Newton's steps descend to it: the cubic is convex there).
double mean_of_same_volume(const Symmetric& dev, double norm2, double scale, double j, double mean) {
  const double second = -0.5 * scale * scale * norm2, third = scale * scale * scale * determinant(dev) - j * j;
  for (int k = 0; k < 40; ++k) {
    const double step = (mean * (mean * mean + second) + third) / (3 * mean * mean + second);
    mean -= step;
    if (!(std::abs(step) > 1e-15 * mean)) break;
  }
  return mean;
}

Return plastic_flow(const SolidMaterial& m, const Kinematics& k, double dt, const Symmetric& dev, double norm2,
                    double mean, Symmetric& metric, double& strain) {
  const double trial = m.mu * std::sqrt(1.5 * norm2), slope = 3 * m.mu * mean;
  if (!(trial > k.j * (m.material.yield_stress + m.material.hardening_modulus * strain))) return {1, mean};
  const double increment = plastic_increment(m.material, trial, slope, k.j, strain, dt);
  const double scale = std::max(0.0, 1 - slope * increment / trial);
  const double new_mean = mean_of_same_volume(dev, norm2, scale, k.j, mean);
  const Matrix3d inverse_transposed = k.cofactor / k.j;
  const Symmetric inverse = product(inverse_transposed.transpose(), inverse_transposed.transpose());  // of F^T F
  const Symmetric flowed = scale * metric + (new_mean - scale * mean) * inverse;
  const double thinness = trace(flowed);
  if (!std::isfinite(thinness) || (thinness > kThinnest && thinness > trace(metric))) return {1, mean};
  metric = flowed;
  strain += increment;
  // By the stress after the return: the trial stress never acted on anything.
  return {scale, new_mean, scale * trial * increment};
}

struct Response {
  Matrix3d stress;            // first Piola-Kirchhoff
  double energy, dissipated;  // per volume at rest
  double greatest_stretch;    // greatest eigenvalue of be
};

Response respond(const SolidMaterial& m, const Kinematics& k, double dt, Symmetric& metric, double& strain) {
  const Matrix3d pulled = m.plastic ? Matrix3d(k.f * full(metric)) : k.f;  // be F^-T
  const Symmetric be = product(pulled, k.f), dev = deviator(be);
  const double mean = trace(be) / 3, norm2 = squared_norm(dev);
  Return to{1, mean};
  if (m.plastic && dt > 0 && k.j > kFlat) to = plastic_flow(m, k, dt, dev, norm2, mean, metric, strain);
  double pressure = m.dilation * (k.j - 1) - m.mu;
  Response r;
  r.energy = m.mu * (1.5 * (to.mean - 1) - (k.j - 1)) + 0.5 * m.dilation * (k.j - 1) * (k.j - 1);
  r.dissipated = to.dissipated;
  r.greatest_stretch = to.mean + to.scale * std::sqrt(2.0 / 3 * norm2);
  if (to.scale != 1) pressure += m.mu * (to.mean - to.scale * mean) / k.j;
  r.stress = (m.mu * to.scale) * pulled + pressure * k.cofactor;
  return r;
}

// Bounds of an element's frequencies. Displacements u of its corners, sum |u|^2 = 1, have gradients h with |h|^2 <= the
// greatest eigenvalue of the spread, (tr h)^2 <= its trace; each corner has 1/N of the mass.
struct Frequency {
  double squared;  // 1/s^2
  double length;   // of the element across its thinnest direction
  double damping;  // per kinematic viscosity of volume: decay rate
};

template <int N>
Frequency frequency(const SolidShape<N>& shape, const SolidMaterial& m, const Matrix3d& cof, double j, double stretch,
                    const Symmetric& metric, double deformation_norm2) {
  constexpr double kLength = N == 8 ? 0.5 : 4.0 / 3;  // exact for cubes, regular tetrahedra
  const Matrix3d pushed = cof * full(shape.spread);
  const Symmetric area = product(pushed, cof);  // J^2 times the present spread
  const double per_mass = N / m.material.density, pressure = m.dilation * (j - 1) - m.mu;
  if (j > kFlat) {
    const double volume = trace(area) / (j * j), greatest = greatest_eigenvalue(area) / (j * j);
    const double dilation = std::max(0.0, (m.dilation * j + pressure) * j),
                 rest = std::abs(j * pressure) + m.mu * stretch;
    return {per_mass * (dilation * volume + rest * greatest), std::sqrt(kLength / greatest), per_mass * volume * j};
  }
  const double rest = std::abs(pressure) * std::sqrt(deformation_norm2) + m.mu * greatest_eigenvalue(metric);
  return {per_mass * (m.dilation * trace(area) + rest * shape.greatest_spread),
          std::sqrt(kLength / shape.greatest_spread), per_mass * trace(area) / kFlat};
}

// Adds bulk viscosity to the stress; returns the rate of decay that it causes.
double add_viscosity(const SolidMaterial& m, const Kinematics& k, const Frequency& w, Response& r, double& power) {
  const double j = std::max(k.j, kFlat), rate = std::max(0.0, -k.volume_rate / j);
  const double viscosity =
      m.material.density / j * w.length * (kLinearViscosity * m.sound + kQuadraticViscosity * w.length * rate);
  r.stress -= (viscosity * rate) * k.cofactor;
  power = viscosity * rate * std::max(0.0, -k.volume_rate);
  return 0.5 * viscosity * w.damping;
}

// `squared`, of an element without hourglass springs, raised to bound that with them as well.
double squared_with_hourglass(const SolidShape<8>& shape, const SolidMaterial& m, const SolidState<8>& state,
                              double squared) {
  double coupling = 1, steepest = 0;
  for (int a = 0; a < 4; ++a) {
    coupling += 2 * shape.mode_slopes[a] * state.modes[a].squaredNorm();
    steepest = std::max(steepest, shape.mode_slopes[a]);
  }
  return coupling * std::max(squared, m.material.youngs_modulus * steepest / (3 * m.material.density));
}

double longest_step(double squared, double decay) { return 2 / (std::sqrt(squared + decay * decay) + decay); }

// Hourglass springs of hexahedra: forces at the corners, and what they add to volume times stress. Returns their
// energy.
double add_hourglass(const SolidShape<8>& shape, const SolidMaterial& m, const Kinematics& k, std::span<const Vec3> x,
                     double dt, SolidState<8>& state, Matrix3d& stress, Vec3* out) {
  std::array<Vec3, 8> d;
  d[0].setZero();
  for (int i = 1; i < 8; ++i) d[i] = 0.125 * (x[shape.vertices[i]] - x[shape.vertices[0]]);
  const bool flows = m.plastic && dt > 0 && k.j > kFlat;
  const double young = m.material.youngs_modulus;
  const double limit = 1.5 * (m.material.yield_stress + m.material.hardening_modulus * state.plastic_strain) / young;
  double energy = 0;
  std::array<Vec3, 4> force;
  for (int a = 0; a < 4; ++a) {
    const double slope = shape.mode_slopes[a], stiffness = young * shape.volume * slope / (a == 3 ? 9 : 3);
    Vec3 q = -(k.f * state.modes[a]);
    for (int i = 1; i < 8; ++i) q += kModes[a][i] * d[i];
    double norm2 = q.squaredNorm();
    if (flows && norm2 * slope > limit * limit) {
      const double keep = limit / std::sqrt(norm2 * slope);
      const Vec3 flowed = state.modes[a] + k.cofactor.transpose() * q * ((1 - keep) / k.j);
      if ((flowed - shape.modes[a]).squaredNorm() * slope <= kFarthestMode * kFarthestMode) {
        state.modes[a] = flowed;
        state.numerical_work += 0.5 * stiffness * norm2 * (1 - keep * keep);
        q *= keep;
        norm2 *= keep * keep;
      }
    }
    energy += 0.5 * stiffness * norm2;
    force[a] = stiffness * q;
    stress.noalias() -= force[a] * state.modes[a].transpose();
    force[a] *= 0.125;
  }
  for (int i = 1; i < 8; ++i) {
    out[i] = -kModes[0][i] * force[0] - kModes[1][i] * force[1] - kModes[2][i] * force[2] - kModes[3][i] * force[3];
  }
  return energy;
}

// The modes' own part of a shape at rest.
void set_modes(const std::array<Vec3, 8>& x, SolidShape<8>& shape) {
  Vec3 slopes;
  for (int d = 0; d < 3; ++d) {
    Vec3 gradient = Vec3::Zero();  // of xi, eta or zeta
    for (int i = 0; i < 8; ++i) gradient += kCube[i][d] * shape.gradients[i];
    slopes[d] = gradient.squaredNorm();
  }
  for (int a = 0; a < 4; ++a) {
    shape.mode_slopes[a] = a == 3 ? slopes.minCoeff() : std::min(slopes[(a + 1) % 3], slopes[(a + 2) % 3]);
    shape.modes[a].setZero();
    for (int i = 0; i < 8; ++i) shape.modes[a] += 0.125 * kModes[a][i] * (x[i] - x[0]);
  }
}

void set_gradients(const std::array<Vec3, 4>& x, SolidShape<4>& shape) {
  Matrix3d edges;
  for (int i = 0; i < 3; ++i) edges.col(i) = x[i + 1] - x[0];
  const Matrix3d cof = cofactor(edges);
  const double six_volumes = edges.col(0).dot(cof.col(0));
  shape.volume = six_volumes / 6;
  for (int i = 0; i < 3; ++i) shape.gradients[i + 1] = cof.col(i) / six_volumes;
}

// Means over the element; 2 x 2 x 2 Gauss points are exact for them.
void set_gradients(const std::array<Vec3, 8>& x, SolidShape<8>& shape) {
  const double gauss = 1 / std::sqrt(3.0);
  shape.volume = 0;
  for (Vec3& g : shape.gradients) g.setZero();
  for (const auto& p : kCube) {
    std::array<Vec3, 8> local;
    Matrix3d tangents = Matrix3d::Zero();
    for (int i = 0; i < 8; ++i) {
      const Vec3 s(1 + kCube[i][0] * p[0] * gauss, 1 + kCube[i][1] * p[1] * gauss, 1 + kCube[i][2] * p[2] * gauss);
      local[i] = 0.125 * Vec3(kCube[i][0] * s[1] * s[2], s[0] * kCube[i][1] * s[2], s[0] * s[1] * kCube[i][2]);
      tangents += (x[i] - x[0]) * local[i].transpose();
    }
    const Matrix3d cof = cofactor(tangents);
    shape.volume += tangents.col(0).dot(cof.col(0));
    for (int i = 0; i < 8; ++i) shape.gradients[i] += cof * local[i];
  }
  for (Vec3& g : shape.gradients) g /= shape.volume;
}

}  // namespace

SolidMaterial::SolidMaterial(const Part& part)
    : material(part.material),
      mu(shear_modulus(part.material)),
      dilation(lame_lambda(part.material) + mu),
      sound(sound_speed(part.material)),
      plastic(std::isfinite(part.material.yield_stress)),
      rigid(part.rigid) {}

template <int N>
bool set_shape(const std::array<Vec3, N>& x, SolidShape<N>& shape) {
  double size = 0;
  for (const Vec3& corner : x) size = std::max(size, (corner - x[0]).norm());
  set_gradients(x, shape);
  // Either orientation of the corners: the gradients are the same.
  shape.volume = std::abs(shape.volume);
  shape.gradients[0].setZero();
  for (int i = 1; i < N; ++i) shape.gradients[0] -= shape.gradients[i];
  Matrix3d spread = Matrix3d::Zero();
  for (const Vec3& g : shape.gradients) spread += g * g.transpose();
  shape.spread << spread(0, 0), spread(1, 1), spread(2, 2), spread(0, 1), spread(1, 2), spread(0, 2);
  shape.greatest_spread = greatest_eigenvalue(shape.spread);
  if constexpr (N == 8) set_modes(x, shape);
  if (shape.volume > 1e-12 * size * size * size && std::isfinite(shape.greatest_spread)) return true;
  shape.volume = 0;
  return false;
}

template <int N>
double solid_forces(const SolidShape<N>& shape, const SolidMaterial& m, std::span<const Vec3> x,
                    std::span<const Vec3> v, double dt, SolidState<N>& state, Vec3* out) {
  const Kinematics k = kinematics(shape, x, v);
  state.deformation = k.f;
  Response r = respond(m, k, dt, state.plastic_metric, state.plastic_strain);
  Frequency w = frequency(shape, m, k.cofactor, k.j, r.greatest_stretch, state.plastic_metric, k.f.squaredNorm());
  double power = 0;
  const double decay = add_viscosity(m, k, w, r, power);
  state.energy = shape.volume * r.energy;
  if (dt > 0) {
    state.plastic_work += shape.volume * r.dissipated;
    state.numerical_work += shape.volume * power * dt;
  }
  r.stress *= shape.volume;
  if constexpr (N == 8) {
    state.energy += add_hourglass(shape, m, k, x, dt, state, r.stress, out);
    w.squared = squared_with_hourglass(shape, m, state, w.squared);
  } else {
    for (int i = 1; i < N; ++i) out[i].setZero();
  }
  Vec3 sum = Vec3::Zero();
  for (int i = 1; i < N; ++i) {
    out[i].noalias() -= r.stress * shape.gradients[i];
    sum += out[i];
  }
  out[0] = -sum;
  return std::isfinite(w.squared) && std::isfinite(sum[0] + sum[1] + sum[2]) ? longest_step(w.squared, decay) : -1;
}

template <int N>
double stable_step(const SolidShape<N>& shape, const SolidMaterial& m, const SolidState<N>& state) {
  Kinematics k{state.deformation, cofactor(state.deformation), 0, 0};
  k.j = k.f.col(0).dot(k.cofactor.col(0));
  Symmetric metric = state.plastic_metric;
  double strain = state.plastic_strain, power = 0;
  Response r = respond(m, k, 0, metric, strain);
  Frequency w = frequency(shape, m, k.cofactor, k.j, r.greatest_stretch, metric, k.f.squaredNorm());
  const double decay = add_viscosity(m, k, w, r, power);
  if constexpr (N == 8) w.squared = squared_with_hourglass(shape, m, state, w.squared);
  return longest_step(w.squared, decay);
}

template <int N>
Matrix3d stress_times_volume(const SolidShape<N>& shape, const SolidMaterial& m, const SolidState<N>& state) {
  const Matrix3d& f = state.deformation;
  const double j = f.col(0).dot(f.col(1).cross(f.col(2)));
  const Matrix3d be = f * full(state.plastic_metric) * f.transpose();
  return shape.volume * (m.mu * be + j * (m.dilation * (j - 1) - m.mu) * Matrix3d::Identity());
}

template bool set_shape<4>(const std::array<Vec3, 4>&, SolidShape<4>&);
template bool set_shape<8>(const std::array<Vec3, 8>&, SolidShape<8>&);
template double solid_forces(const SolidShape<4>&, const SolidMaterial&, std::span<const Vec3>, std::span<const Vec3>,
                             double, SolidState<4>&, Vec3*);
template double solid_forces(const SolidShape<8>&, const SolidMaterial&, std::span<const Vec3>, std::span<const Vec3>,
                             double, SolidState<8>&, Vec3*);
template double stable_step(const SolidShape<4>&, const SolidMaterial&, const SolidState<4>&);
template double stable_step(const SolidShape<8>&, const SolidMaterial&, const SolidState<8>&);
template Matrix3d stress_times_volume(const SolidShape<4>&, const SolidMaterial&, const SolidState<4>&);
template Matrix3d stress_times_volume(const SolidShape<8>&, const SolidMaterial&, const SolidState<8>&);

}  // namespace volccd::simulation::detail
