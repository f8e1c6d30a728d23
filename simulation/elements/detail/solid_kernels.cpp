#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/simulation/elements/detail/solid_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <volccd/simulation/elements/detail/solid_kernels.hpp>

HWY_BEFORE_NAMESPACE();
namespace volccd::simulation::detail::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, kSolidLanes>;
using V = hn::Vec<D>;

constexpr double kLinearViscosity = 0.06, kQuadraticViscosity = 1.44;

struct Matrix {
  V m[3][3];
};
struct Sym {
  V s[6];  // xx, yy, zz, xy, yz, zx
};

// Separate products and sums, never fused, so that the results are the same bit for bit on every processor.
HWY_INLINE V num(double x) { return hn::Set(D(), x); }
HWY_INLINE V load(const SolidLane& from, int lane) { return hn::LoadU(D(), from + lane); }
HWY_INLINE void store(V value, SolidLane& to, int lane) { hn::StoreU(value, D(), to + lane); }
HWY_INLINE V dot(const V (&a)[3], const V (&b)[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

HWY_INLINE Matrix zero() {
  Matrix a;
  for (auto& row : a.m) row[0] = row[1] = row[2] = num(0);
  return a;
}
HWY_INLINE Sym load(const SolidLane (&from)[6], int lane) {
  Sym a;
  for (int k = 0; k < 6; ++k) a.s[k] = load(from[k], lane);
  return a;
}
HWY_INLINE Matrix times(const Matrix& a, const Sym& b) {
  const V *s = b.s, rows[3][3] = {{s[0], s[3], s[5]}, {s[3], s[1], s[4]}, {s[5], s[4], s[2]}};
  Matrix c;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) c.m[i][k] = dot(a.m[i], rows[k]);
  }
  return c;
}
// a b^T where that is symmetric.
HWY_INLINE Sym product(const Matrix& a, const Matrix& b) {
  return {{dot(a.m[0], b.m[0]), dot(a.m[1], b.m[1]), dot(a.m[2], b.m[2]), dot(a.m[0], b.m[1]), dot(a.m[1], b.m[2]),
           dot(a.m[0], b.m[2])}};
}
HWY_INLINE Matrix cofactors(const Matrix& a) {
  Matrix c;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, k1 = (k + 1) % 3, k2 = (k + 2) % 3;
      c.m[i][k] = a.m[i1][k1] * a.m[i2][k2] - a.m[i1][k2] * a.m[i2][k1];
    }
  }
  return c;
}
HWY_INLINE V trace(const Sym& a) { return a.s[0] + a.s[1] + a.s[2]; }
HWY_INLINE V inner(const Matrix& a, const Matrix& b) {
  return dot(a.m[0], b.m[0]) + dot(a.m[1], b.m[1]) + dot(a.m[2], b.m[2]);
}
// Returns the deviator, and its squared norm in `norm2`.
HWY_INLINE Sym deviator(Sym a, V mean, V& norm2) {
  for (int k = 0; k < 3; ++k) a.s[k] = a.s[k] - mean;
  const V shear = a.s[3] * a.s[3] + a.s[4] * a.s[4] + a.s[5] * a.s[5];
  norm2 = a.s[0] * a.s[0] + a.s[1] * a.s[1] + a.s[2] * a.s[2] + (shear + shear);
  return a;
}
// An upper bound of the greatest eigenvalue, exact if the two smaller eigenvalues are equal.
HWY_INLINE V greatest_eigenvalue(const Sym& a) {
  V norm2;
  const V mean = trace(a) * num(1.0 / 3);
  deviator(a, mean, norm2);
  return mean + hn::Sqrt(norm2 * num(2.0 / 3));
}

struct Kinematics {
  Matrix f, cofactor;
  V j, volume_rate;
  V strain_rate2;  // squared norm of the rate of deformation times J
};

template <int N>
HWY_INLINE Kinematics kinematics(SolidBatch<N>& b, int lane) {
  Kinematics k;
  k.f = zero();
  Matrix rate = zero();
  for (int i = 1; i < N && !b.deformation_given; ++i) {
    for (int c = 0; c < 3; ++c) {
      const V g = load(b.gradients[i][c], lane);
      for (int r = 0; r < 3; ++r) {
        k.f.m[r][c] = k.f.m[r][c] + load(b.x[i][r], lane) * g;
        rate.m[r][c] = rate.m[r][c] + load(b.v[i][r], lane) * g;
      }
    }
  }
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      if (b.deformation_given)
        k.f.m[r][c] = load(b.f[r][c], lane);
      else
        store(k.f.m[r][c], b.f[r][c], lane);
    }
  }
  k.cofactor = cofactors(k.f);
  k.j = dot(k.f.m[0], k.cofactor.m[0]);
  k.volume_rate = inner(k.cofactor, rate);
  store(k.j, b.j, lane);
  store(k.volume_rate, b.volume_rate, lane);
  k.strain_rate2 = num(0);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c <= r; ++c) {
      const V twice = dot(rate.m[r], k.cofactor.m[c]) + dot(rate.m[c], k.cofactor.m[r]);
      k.strain_rate2 = k.strain_rate2 + num(r == c ? 0.25 : 0.5) * (twice * twice);
    }
  }
  return k;
}

// Radial return of the lanes that yield, one element at a time.
template <int N>
HWY_INLINE void yield(SolidBatch<N>& b, int lane, double dt, const Kinematics& k, const Sym& dev, V norm2, V mean,
                      V& scale, V& new_mean) {
  const V trial = load(b.mu, lane) * hn::Sqrt(norm2 * num(1.5));
  const auto beyond = hn::And(trial > k.j * load(b.yield, lane), k.j > num(kFlat));
  if (!(dt > 0) || hn::AllFalse(D(), beyond)) return;
  for (int i = 0; i < 6; ++i) store(dev.s[i], b.deviator[i], lane);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) store(k.cofactor.m[r][c], b.cofactor[r][c], lane);
  }
  store(norm2, b.norm2, lane);
  store(mean, b.mean, lane);
  store(num(1), b.scale, lane);
  store(mean, b.new_mean, lane);
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(D(), beyond, bits);
  for (int i = 0; i < static_cast<int>(hn::Lanes(D())); ++i) {
    if ((bits[0] >> i & 1) && lane + i < b.count) flow(b, lane + i, dt);
  }
  scale = load(b.scale, lane);
  new_mean = load(b.new_mean, lane);
}

// Bounds of an element's frequencies. Displacements u of its corners, sum |u|^2 = 1, have gradients h with |h|^2 <= the
// greatest eigenvalue of the spread, (tr h)^2 <= its trace; each corner has 1/N of the mass.
struct Frequency {
  V squared;  // 1/s^2
  V length;   // of the element across its thinnest direction
  V damping;  // rate of decay per viscosity of volume
};

template <int N>
HWY_INLINE Frequency frequency(const SolidBatch<N>& b, int lane, const Kinematics& k, V pressure, V stretch) {
  const V shape = num(N == 8 ? 0.5 : 4.0 / 3);  // length^2 times spread: exact for cubes, regular tetrahedra
  const Sym area = product(times(k.cofactor, load(b.spread, lane)), k.cofactor);  // J^2 times the present spread
  const V per_mass = num(N) / load(b.density, lane), mu = load(b.mu, lane), dilation = load(b.dilation, lane);
  const V flat = num(kFlat), j = hn::Max(k.j, flat), per_j2 = num(1) / (j * j), total = trace(area);
  const V greatest = greatest_eigenvalue(area) * per_j2;
  const V bulk = hn::Max(num(0), (dilation * j + pressure) * j) * total * per_j2;
  Frequency w;
  w.squared = per_mass * (bulk + (hn::Abs(j * pressure) + mu * stretch) * greatest);
  w.length = hn::Sqrt(shape / greatest);
  w.damping = per_mass * total / j;
  const auto steep = k.j > flat;
  if (HWY_LIKELY(hn::AllTrue(D(), steep))) return w;
  const V spread = load(b.greatest_spread, lane);
  const V rest = hn::Abs(pressure) * hn::Sqrt(inner(k.f, k.f)) + mu * greatest_eigenvalue(load(b.metric, lane));
  w.squared = hn::IfThenElse(steep, w.squared, per_mass * (dilation * total + rest * spread));
  w.length = hn::IfThenElse(steep, w.length, hn::Sqrt(shape / spread));
  return w;
}

// Forces and energy of the hourglass springs of hexahedra.
struct Hourglass {
  V g[4][3];  // spring forces over 8
  V energy;
};

// h[mode] of values at the corners, the first of which is 0.
HWY_INLINE void mode_sums(const V (&d)[8], V (&h)[4]) {
  const V s[4] = {d[1], d[3] + d[2], d[4] + d[5], d[7] + d[6]};
  const V t[4] = {d[1], d[2] - d[3], d[5] - d[4], d[6] - d[7]};
  h[0] = (s[0] + s[3]) - (s[1] + s[2]);
  h[1] = (t[2] + t[3]) - (t[0] + t[1]);
  h[2] = (t[1] + t[3]) - (t[0] + t[2]);
  h[3] = (t[0] + t[3]) - (t[1] + t[2]);
}

HWY_INLINE void yield_modes(SolidBatch<8>& b, int lane, double dt, const Kinematics& k, V (&q)[4][3], V (&norm2)[4]) {
  const V limit = num(1.5) * load(b.yield, lane) / load(b.young, lane);
  V worst = num(0);  // squared strain
  for (int a = 0; a < 4; ++a) worst = hn::Max(worst, norm2[a] * load(b.mode_slopes[a], lane));
  const auto beyond = hn::And(worst > limit * limit, k.j > num(kFlat));
  if (!(dt > 0) || hn::AllFalse(D(), beyond)) return;
  for (int a = 0; a < 4; ++a) {
    for (int c = 0; c < 3; ++c) store(q[a][c], b.q[a][c], lane);
    store(norm2[a], b.q_norm2[a], lane);
  }
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) store(k.cofactor.m[r][c], b.cofactor[r][c], lane);
  }
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(D(), beyond, bits);
  for (int i = 0; i < static_cast<int>(hn::Lanes(D())); ++i) {
    if ((bits[0] >> i & 1) && lane + i < b.count) flow_modes(b, lane + i);
  }
  for (int a = 0; a < 4; ++a) {
    for (int c = 0; c < 3; ++c) q[a][c] = load(b.q[a][c], lane);
    norm2[a] = load(b.q_norm2[a], lane);
  }
}

// Adds the contribution of the springs to volume times stress, and increases `squared` to a bound of their frequency.
HWY_INLINE Hourglass hourglass(SolidBatch<8>& b, int lane, double dt, const Kinematics& k, Matrix& stress, V& squared) {
  V q[4][3], norm2[4];
  for (int c = 0; c < 3; ++c) {
    V d[8], h[4];
    for (int i = 1; i < 8; ++i) d[i] = load(b.x[i][c], lane);
    mode_sums(d, h);
    for (int a = 0; a < 4; ++a) {
      const V mode[3] = {load(b.modes[a][0], lane), load(b.modes[a][1], lane), load(b.modes[a][2], lane)};
      q[a][c] = num(0.125) * h[a] - dot(k.f.m[c], mode);
    }
  }
  for (int a = 0; a < 4; ++a) norm2[a] = dot(q[a], q[a]);
  yield_modes(b, lane, dt, k, q, norm2);
  Hourglass out;
  out.energy = num(0);
  V coupling = num(0.5), steepest = num(0);
  const V young = load(b.young, lane), volume = load(b.volume, lane);
  for (int a = 0; a < 4; ++a) {
    const V slope = load(b.mode_slopes[a], lane), stiffness = young * volume * slope * num(a == 3 ? 1.0 / 9 : 1.0 / 3);
    const V mode[3] = {load(b.modes[a][0], lane), load(b.modes[a][1], lane), load(b.modes[a][2], lane)};
    for (int r = 0; r < 3; ++r) {
      const V force = stiffness * q[a][r];
      for (int c = 0; c < 3; ++c) stress.m[r][c] = stress.m[r][c] - force * mode[c];
      out.g[a][r] = num(0.125) * force;
    }
    out.energy = out.energy + num(0.5) * stiffness * norm2[a];
    coupling = coupling + slope * dot(mode, mode);
    steepest = hn::Max(steepest, slope);
  }
  // Springs and stress share displacements as far as the modes have an affine part.
  squared = (coupling + coupling) * hn::Max(squared, young * steepest / (num(3) * load(b.density, lane)));
  return out;
}

// The forces of the springs along axis c at each corner: the negative of sums like those of mode_sums().
HWY_INLINE void add_mode_forces(const Hourglass& h, int c, V (&force)[8]) {
  const V sum = h.g[1][c] + h.g[2][c], difference = h.g[1][c] - h.g[2][c], even = h.g[0][c], odd = h.g[3][c];
  // Edges along xi at (eta, zeta) = (-, -), (+, -), (-, +), (+, +).
  const V t[4] = {odd - sum, hn::Neg(odd) - difference, difference - odd, sum + odd};
  const V s[4] = {even, hn::Neg(even), hn::Neg(even), even};
  constexpr int kEdges[4][2] = {{0, 1}, {3, 2}, {4, 5}, {7, 6}};
  for (int e = 0; e < 4; ++e) {
    force[kEdges[e][0]] = force[kEdges[e][0]] - (s[e] - t[e]);
    force[kEdges[e][1]] = force[kEdges[e][1]] - (s[e] + t[e]);
  }
}

template <int N>
HWY_INLINE void store_forces(SolidBatch<N>& b, int lane, const Matrix& stress, const Hourglass* springs, V& all) {
  all = num(0);
  for (int r = 0; r < 3; ++r) {
    V force[N];
    force[0] = num(0);
    for (int i = 1; i < N; ++i) {
      const V g[3] = {load(b.gradients[i][0], lane), load(b.gradients[i][1], lane), load(b.gradients[i][2], lane)};
      force[i] = hn::Neg(dot(stress.m[r], g));
    }
    if constexpr (N == 8) add_mode_forces(*springs, r, force);
    V sum = num(0);
    for (int i = 1; i < N; ++i) {
      store(force[i], b.force[i][r], lane);
      sum = sum + force[i];
    }
    store(hn::Neg(sum), b.force[0][r], lane);
    all = all + sum;
  }
}

template <int N>
HWY_INLINE void respond_lanes(SolidBatch<N>& b, int lane, double dt) {
  const Kinematics k = kinematics(b, lane);
  const V mu = load(b.mu, lane), one = num(1), dilation = load(b.dilation, lane), volume = load(b.volume, lane);
  const Matrix pulled = times(k.f, load(b.metric, lane));  // be F^-T
  const Sym be = product(pulled, k.f);
  const V mean = trace(be) * num(1.0 / 3);
  V norm2, scale = one, new_mean = mean;
  const Sym dev = deviator(be, mean, norm2);
  yield(b, lane, dt, k, dev, norm2, mean, scale, new_mean);

  const V expansion = k.j - one, pressure = dilation * expansion - mu;
  const V stretch = new_mean + scale * hn::Sqrt(norm2 * num(2.0 / 3));
  Frequency w = frequency(b, lane, k, pressure, stretch);

  const V zeros = num(0), j = hn::Max(k.j, num(kFlat));
  const V rate = hn::Max(zeros, hn::Neg(k.volume_rate) / j);
  const V viscosity = load(b.density, lane) / j * w.length *
                      (num(kLinearViscosity) * load(b.sound, lane) + num(kQuadraticViscosity) * w.length * rate);
  const V viscous = viscosity * rate, decay = num(0.5) * viscosity * w.damping;
  store(viscous, b.viscous_pressure, lane);

  const V flowed = hn::IfThenElseZero(hn::Ne(scale, one), mu * (new_mean - scale * mean) / k.j);
  const V of_pulled = mu * scale * volume, of_cofactor = (pressure + flowed - viscous) * volume;
  Matrix stress;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) stress.m[r][c] = of_pulled * pulled.m[r][c] + of_cofactor * k.cofactor.m[r][c];
  }
  V energy = volume * (mu * (num(1.5) * (new_mean - one) - expansion) + num(0.5) * dilation * expansion * expansion);
  V all;
  if constexpr (N == 8) {
    const Hourglass springs = hourglass(b, lane, dt, k, stress, w.squared);
    energy = energy + springs.energy;
    store_forces(b, lane, stress, &springs, all);
  } else {
    store_forces(b, lane, stress, nullptr, all);
  }
  store(energy, b.energy, lane);
  const V oscillation = num(2) / (hn::Sqrt(w.squared + decay * decay) + decay);
  const V step = hn::Min(oscillation, num(kStrainPerStep) * j / hn::Sqrt(k.strain_rate2));
  const auto finite = hn::And(hn::IsFinite(w.squared), hn::IsFinite(all));
  store(hn::IfThenElse(finite, step, num(-1)), b.step, lane);
}

void respond4(SolidBatch<4>& b, double dt) {
  for (int lane = 0; lane < kSolidLanes; lane += static_cast<int>(hn::Lanes(D()))) respond_lanes(b, lane, dt);
}
void respond8(SolidBatch<8>& b, double dt) {
  for (int lane = 0; lane < kSolidLanes; lane += static_cast<int>(hn::Lanes(D()))) respond_lanes(b, lane, dt);
}

}  // namespace volccd::simulation::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd::simulation::detail {

HWY_EXPORT(respond4);
HWY_EXPORT(respond8);

void respond(SolidBatch<4>& batch, double dt) { HWY_DYNAMIC_DISPATCH(respond4)(batch, dt); }
void respond(SolidBatch<8>& batch, double dt) { HWY_DYNAMIC_DISPATCH(respond8)(batch, dt); }

}  // namespace volccd::simulation::detail
#endif
