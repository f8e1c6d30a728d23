#include <volccd/simulation/elements/detail/solid_element.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include <volccd/simulation/elements/detail/solid_kernels.hpp>
#include <volccd/simulation/elements/material.hpp>

namespace volccd::simulation::detail {

namespace {

using Eigen::Matrix3d;

// Greatest trace of Cp^-1: a thickness of a tenth.
constexpr double kThinnest = 100;
// Limit of the plastic flow of hourglass modes, in half edges; beyond it, corners would be inverted.
constexpr double kFarthestMode = 0.5;

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

// a a^T.
Symmetric square(const Matrix3d& a) {
  const auto row = [&](int i, int j) { return a(i, 0) * a(j, 0) + a(i, 1) * a(j, 1) + a(i, 2) * a(j, 2); };
  return (Symmetric() << row(0, 0), row(1, 1), row(2, 2), row(0, 1), row(1, 2), row(0, 2)).finished();
}

double trace(const Symmetric& s) { return s[0] + s[1] + s[2]; }

double determinant(const Symmetric& s) {
  return s[0] * (s[1] * s[2] - s[4] * s[4]) - s[3] * (s[3] * s[2] - s[4] * s[5]) + s[5] * (s[3] * s[4] - s[1] * s[5]);
}

double greatest_eigenvalue(const Symmetric& s) {
  const double mean = trace(s) / 3;
  const double norm2 = (s.head<3>().array() - mean).square().sum() + 2 * s.tail<3>().squaredNorm();
  return mean + std::sqrt(2.0 / 3 * norm2);
}

Matrix3d cofactor(const Matrix3d& f) {
  Matrix3d c;
  c.col(0) = f.col(1).cross(f.col(2));
  c.col(1) = f.col(2).cross(f.col(0));
  c.col(2) = f.col(0).cross(f.col(1));
  return c;
}

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

// F^-1 (transposed: the cofactors over J) of one lane.
template <int N>
Matrix3d inverse(const SolidBatch<N>& b, int lane) {
  Matrix3d inverse;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) inverse(c, r) = b.cofactor[r][c][lane] / b.j[lane];
  }
  return inverse;
}

// The data of the hourglass modes in a shape at rest.
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

// If two corners are one vertex, only the sum of their shares matters; equal shares give the smallest bound for the
// stable step.
void share_gradients(SolidShape<8>& shape) {
  for (const int i : {1, 5}) {
    const Vec3 mean = (shape.gradients[i] + shape.gradients[i + 1]) / 2;
    shape.gradients[i] = shape.gradients[i + 1] = mean;
  }
}

// On a wedge's six vertices xi eta is affine, and xi eta zeta is -eta zeta.
void drop_modes(SolidShape<8>& shape) {
  for (const int a : {2, 3}) {
    shape.mode_slopes[a] = 0;
    shape.modes[a].setZero();
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

/// The quantities that do not depend on the present positions.
template <int N>
void fill(SolidBatch<N>& b, int lane, const SolidShape<N>& shape, const SolidMaterial& m, const SolidState<N>& state) {
  b.shapes[lane] = &shape;
  b.materials[lane] = &m;
  for (int i = 1; i < N; ++i) {
    for (int c = 0; c < 3; ++c) b.gradients[i][c][lane] = shape.gradients[i][c];
  }
  for (int c = 0; c < 6; ++c) b.spread[c][lane] = shape.spread[c];
  for (int c = 0; c < 6; ++c) b.metric[c][lane] = state.plastic_metric[c];
  for (int a = 0; a < mode_count(N); ++a) {
    b.mode_slopes[a][lane] = shape.mode_slopes[a];
    for (int c = 0; c < 3; ++c) b.modes[a][c][lane] = state.modes[a][c];
  }
  b.volume[lane] = shape.volume;
  b.greatest_spread[lane] = shape.greatest_spread;
  b.mu[lane] = m.mu;
  b.dilation[lane] = m.dilation;
  b.density[lane] = m.material.density * shape.packing;
  b.sound[lane] = m.sound;
  b.young[lane] = m.material.youngs_modulus;
  b.yield[lane] = yield_stress(m.material, state.plastic_strain, 0);
}

template <int N>
void gather(SolidBatch<N>& b, int lane, const SolidShape<N>& shape, std::span<const Vec3> x, std::span<const Vec3> v) {
  // Positions relative to the first corner: rounding errors are then proportional to the element's size.
  const Vec3 &x0 = x[shape.vertices[0]], &v0 = v[shape.vertices[0]];
  for (int i = 1; i < N; ++i) {
    const Vec3 &xi = x[shape.vertices[i]], &vi = v[shape.vertices[i]];
    for (int c = 0; c < 3; ++c) {
      b.x[i][c][lane] = xi[c] - x0[c];
      b.v[i][c][lane] = vi[c] - v0[c];
    }
  }
}

template <int N>
void take(const SolidBatch<N>& b, int lane, double dt, Vec3* out) {
  SolidState<N>& state = *b.states[lane];
  for (int i = 0; i < N; ++i) {
    for (int c = 0; c < 3; ++c) out[i][c] = b.force[i][c][lane];
  }
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) state.deformation(r, c) = b.f[r][c][lane];
  }
  state.energy = b.energy[lane];
  const double before = state.viscous_pressure;
  state.viscous_pressure = b.viscous_pressure[lane];
  // The work is that of the mean force over both ends of the step, as in a leapfrog scheme.
  state.numerical_work -= 0.5 * (before + state.viscous_pressure) * b.volume_rate[lane] * b.volume[lane] * dt;
}

}  // namespace

SolidMaterial::SolidMaterial(const Body& body)
    : material(body.material),
      mu(shear_modulus(body.material)),
      dilation(lame_lambda(body.material) + mu),
      sound(sound_speed(body.material)),
      rigid(body.rigid) {}

template <int N>
bool set_shape(const std::array<Vec3, N>& x, SolidShape<N>& shape, [[maybe_unused]] bool wedge) {
  double size = 0;
  for (const Vec3& corner : x) size = std::max(size, (corner - x[0]).norm());
  set_gradients(x, shape);
  // Either orientation of the corners: the gradients are the same.
  shape.volume = std::abs(shape.volume);
  shape.gradients[0].setZero();
  for (int i = 1; i < N; ++i) shape.gradients[0] -= shape.gradients[i];
  if constexpr (N == 8)
    if (wedge) share_gradients(shape);
  Matrix3d spread = Matrix3d::Zero();
  for (const Vec3& g : shape.gradients) spread += g * g.transpose();
  shape.spread << spread(0, 0), spread(1, 1), spread(2, 2), spread(0, 1), spread(1, 2), spread(0, 2);
  shape.greatest_spread = greatest_eigenvalue(shape.spread);
  if constexpr (N == 8) set_modes(x, shape);
  if constexpr (N == 8)
    if (wedge) drop_modes(shape);
  if (shape.volume > 1e-12 * size * size * size && std::isfinite(shape.greatest_spread)) return true;
  shape.volume = 0;
  return false;
}

template <int N>
void flow(SolidBatch<N>& b, int lane, double dt) {
  SolidState<N>& state = *b.states[lane];
  const SolidMaterial& m = *b.materials[lane];
  const double mean = b.mean[lane], norm2 = b.norm2[lane], j = b.j[lane];
  Symmetric dev;
  for (int c = 0; c < 6; ++c) dev[c] = b.deviator[c][lane];
  const double trial = m.mu * std::sqrt(1.5 * norm2), slope = 3 * m.mu * mean;
  const double increment = plastic_increment(m.material, trial, slope, j, state.plastic_strain, dt);
  const double scale = std::max(0.0, 1 - slope * increment / trial);
  const double new_mean = mean_of_same_volume(dev, norm2, scale, j, mean);
  const Symmetric flowed = scale * state.plastic_metric + (new_mean - scale * mean) * square(inverse(b, lane));
  const double thinness = trace(flowed);
  if (!std::isfinite(thinness) || (thinness > kThinnest && thinness > trace(state.plastic_metric))) return;
  state.plastic_metric = flowed;
  state.plastic_strain += increment;
  // Computed with the stress after the return mapping, because the trial stress did no work.
  state.plastic_work += b.volume[lane] * scale * trial * increment;
  for (int c = 0; c < 6; ++c) b.metric[c][lane] = flowed[c];
  b.scale[lane] = scale;
  b.new_mean[lane] = new_mean;
}

void flow_modes(SolidBatch<8>& b, int lane) {
  SolidState<8>& state = *b.states[lane];
  const double young = b.young[lane], limit = 1.5 * b.yield[lane] / young;
  for (int a = 0; a < 4; ++a) {
    const double slope = b.mode_slopes[a][lane], norm2 = b.q_norm2[a][lane];
    if (!(norm2 * slope > limit * limit)) continue;
    const double keep = limit / std::sqrt(norm2 * slope);
    const Vec3 q(b.q[a][0][lane], b.q[a][1][lane], b.q[a][2][lane]);
    const Vec3 flowed = state.modes[a] + (1 - keep) * (inverse(b, lane) * q);
    // The comparison is also false for NaN.
    if (!((flowed - b.shapes[lane]->modes[a]).squaredNorm() * slope <= kFarthestMode * kFarthestMode)) continue;
    state.modes[a] = flowed;
    // Computed with the force after the return mapping, as for the stress.
    state.numerical_work += young * b.volume[lane] * slope * norm2 * keep * (1 - keep) / (a == 3 ? 9 : 3);
    for (int c = 0; c < 3; ++c) {
      b.modes[a][c][lane] = flowed[c];
      b.q[a][c][lane] = keep * q[c];
    }
    b.q_norm2[a][lane] = keep * keep * norm2;
  }
}

template <int N>
SolidBound solid_forces(const SolidRun<N>& run, std::size_t begin, std::size_t end) {
  SolidBatch<N> batch;
  SolidBound bound{std::numeric_limits<double>::infinity()};
  std::array<std::size_t, kSolidLanes> rows{};
  const auto finish = [&] {
    if (batch.count == 0) return;
    const std::size_t last = rows[batch.count - 1];
    const SolidShape<N>& shape = run.shapes[last];
    for (int lane = batch.count; lane < kSolidLanes; ++lane) {
      fill(batch, lane, shape, run.materials[shape.body], run.states[last]);
      gather(batch, lane, shape, run.x, run.v);
    }
    respond(batch, run.dt);
    for (int lane = 0; lane < batch.count; ++lane) {
      take(batch, lane, run.dt, run.out + rows[lane] * N);
      if (!(batch.step[lane] > 0)) bound.broken = std::min(bound.broken, batch.shapes[lane]->slot);
      bound.step = std::min(bound.step, batch.step[lane]);
    }
    batch.count = 0;
  };
  for (std::size_t row = begin; row < end; ++row) {
    const SolidShape<N>& shape = run.shapes[row];
    if (!is_active(shape, run.materials)) continue;
    const int lane = batch.count++;
    rows[lane] = row;
    batch.states[lane] = &run.states[row];
    fill(batch, lane, shape, run.materials[shape.body], run.states[row]);
    gather(batch, lane, shape, run.x, run.v);
    if (batch.count == kSolidLanes) finish();
  }
  finish();
  return bound;
}

template <int N>
double stable_step(const SolidShape<N>& shape, const SolidState<N>& state, std::span<const SolidMaterial> materials) {
  SolidBatch<N> batch{};
  batch.deformation_given = true;
  for (int lane = 0; lane < kSolidLanes; ++lane) {
    fill(batch, lane, shape, materials[shape.body], state);
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) batch.f[r][c][lane] = state.deformation(r, c);
    }
  }
  respond(batch, 0);
  return batch.step[0];
}

template <int N>
Matrix3d stress_times_volume(const SolidShape<N>& shape, const SolidMaterial& m, const SolidState<N>& state) {
  const Matrix3d& f = state.deformation;
  const double j = f.col(0).dot(f.col(1).cross(f.col(2)));
  const Matrix3d be = f * full(state.plastic_metric) * f.transpose();
  return shape.volume * (m.mu * be + j * (m.dilation * (j - 1) - m.mu) * Matrix3d::Identity());
}

template bool set_shape<4>(const std::array<Vec3, 4>&, SolidShape<4>&, bool);
template bool set_shape<8>(const std::array<Vec3, 8>&, SolidShape<8>&, bool);
template void flow(SolidBatch<4>&, int, double);
template void flow(SolidBatch<8>&, int, double);
template SolidBound solid_forces(const SolidRun<4>&, std::size_t, std::size_t);
template SolidBound solid_forces(const SolidRun<8>&, std::size_t, std::size_t);
template double stable_step(const SolidShape<4>&, const SolidState<4>&, std::span<const SolidMaterial>);
template double stable_step(const SolidShape<8>&, const SolidState<8>&, std::span<const SolidMaterial>);
template Matrix3d stress_times_volume(const SolidShape<4>&, const SolidMaterial&, const SolidState<4>&);
template Matrix3d stress_times_volume(const SolidShape<8>&, const SolidMaterial&, const SolidState<8>&);

}  // namespace volccd::simulation::detail
