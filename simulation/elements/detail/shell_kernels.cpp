#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/simulation/elements/detail/shell_kernels.cpp"
#include <hwy/foreach_target.h>
#include <volccd/numerics/vector_lanes-inl.hpp>
#include <volccd/simulation/detail/portable_math.hpp>
#include <volccd/simulation/elements/detail/shell_kernels.hpp>

HWY_BEFORE_NAMESPACE();
namespace volccd::simulation::detail::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, kShellPadding>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;
using DI = hn::RebindToSigned<D>;
using VI = hn::Vec<DI>;

constexpr double kTiny = 1e-300;

using Vector = volccd::detail::HWY_NAMESPACE::LaneVector<V>;

// Products and sums are separate operations, because with fused multiply-add the results would depend on the processor.
HWY_ATTR HWY_INLINE V set(double x) { return hn::Set(D(), x); }
HWY_ATTR HWY_INLINE V load(const std::vector<double>& values, std::size_t i) {
  return hn::LoadU(D(), values.data() + i);
}
HWY_ATTR HWY_INLINE V combine(V a, V s, V b, V t) { return hn::Add(hn::Mul(a, s), hn::Mul(b, t)); }
HWY_ATTR HWY_INLINE Vector combine(const Vector& a, V s, const Vector& b, V t) {
  return {combine(a.x, s, b.x, t), combine(a.y, s, b.y, t), combine(a.z, s, b.z, t)};
}
HWY_ATTR HWY_INLINE VI load_index(const std::vector<std::int32_t>& values, std::size_t i) {
  return hn::PromoteTo(DI(), hn::LoadU(hn::Rebind<std::int32_t, D>(), values.data() + i));
}
HWY_ATTR HWY_INLINE Vector gather(const double* copy, VI index) {
  const D d;
  return {hn::GatherIndex(d, copy, index), hn::GatherIndex(d, copy + 1, index), hn::GatherIndex(d, copy + 2, index)};
}

// Half the logarithm, for x in [2/3, 3/2].
HWY_ATTR HWY_INLINE V near_half_log(V x) {
  const V one = set(1), s = hn::Div(hn::Sub(x, one), hn::Add(x, one)), z = hn::Mul(s, s);
  V sum = set(1.0 / 23);
  for (int k = 21; k >= 1; k -= 2) sum = hn::Add(hn::Mul(sum, z), set(1.0 / k));
  return hn::Mul(s, sum);
}

// Same as portable_atan2(), except for the sign of zero.
HWY_ATTR HWY_INLINE V angle_of(V y, V x) {
  const V ax = hn::Abs(x), ay = hn::Abs(y), hi = hn::Max(ax, ay), lo = hn::Min(ax, ay);
  const M steep = hn::Gt(lo, hn::Mul(set(0.66), hi));
  const V over = hn::IfThenElse(steep, hn::Sub(lo, hi), lo), under = hn::IfThenElse(steep, hn::Add(lo, hi), hi);
  const V t = hn::Div(over, hn::Max(under, set(kTiny))), z = hn::Mul(t, t);
  V p = set(kAtanP[0]), q = set(kAtanQ[0]);
  for (int k = 1; k < 5; ++k) p = hn::Add(hn::Mul(p, z), set(kAtanP[k]));
  for (int k = 1; k < 6; ++k) q = hn::Add(hn::Mul(q, z), set(kAtanQ[k]));
  V angle = hn::Add(hn::Mul(t, hn::Mul(z, hn::Div(p, q))), t);
  angle = hn::Add(angle, hn::IfThenElseZero(steep, set(0.7853981633974483)));
  angle = hn::IfThenElse(hn::Gt(ay, ax), hn::Sub(set(1.5707963267948966), angle), angle);
  angle = hn::IfThenElse(hn::Lt(x, hn::Zero(D())), hn::Sub(set(3.141592653589793), angle), angle);
  return hn::CopySign(angle, y);
}

// Sums are formed element by element, not vertex by vertex, so that they do not depend on the number of lanes.
template <std::size_t N>
HWY_ATTR HWY_INLINE void scatter(const std::vector<std::int32_t> (&vertices)[N], std::size_t i,
                                 const Vector (&force)[N], double* forces) {
  const D d;
  alignas(64) double lanes[N][3][kShellPadding];
  for (std::size_t n = 0; n < N; ++n) {
    hn::Store(force[n].x, d, lanes[n][0]);
    hn::Store(force[n].y, d, lanes[n][1]);
    hn::Store(force[n].z, d, lanes[n][2]);
  }
  for (std::size_t k = 0; k < hn::Lanes(d); ++k) {
    for (std::size_t n = 0; n < N; ++n) {
      double* at = forces + static_cast<std::size_t>(vertices[n][i + k]) * kForceStride / kCopyStride;
      for (int c = 0; c < 3; ++c) at[c] += lanes[n][c][k];
    }
  }
}

HWY_ATTR HWY_INLINE void add_in_order(V values, double& sum) {
  alignas(64) double lanes[kShellPadding];
  hn::Store(values, D(), lanes);
  for (std::size_t k = 0; k < hn::Lanes(D()); ++k) sum += lanes[k];
}

HWY_ATTR HWY_INLINE double greatest(V values) { return hn::GetLane(hn::MaxOfLanes(D(), values)); }

// Lets the scalar code compute the other lanes, one after another; `ordinary` lanes keep their values.
struct Trial {
  V mu1, mu2, mean, difference, shear, radius;  ///< F^T F: eigenvalues; mean and half the difference of the diagonal
  V stress1, stress2, energy;
};
HWY_ATTR HWY_NOINLINE void leave_to_scalar(ShellTables& t, const ShellLaw& law, std::size_t i, double dt, M ordinary,
                                           Trial& trial, double& plastic) {
  const D d;
  alignas(64) MembraneLanes lanes;
  alignas(64) double keep[kShellPadding];
  hn::StoreU(trial.mu1, d, lanes.squared_stretch[0]);
  hn::StoreU(trial.mu2, d, lanes.squared_stretch[1]);
  hn::StoreU(trial.mean, d, lanes.mean);
  hn::StoreU(trial.difference, d, lanes.difference);
  hn::StoreU(trial.shear, d, lanes.shear);
  hn::StoreU(trial.radius, d, lanes.radius);
  hn::StoreU(trial.stress1, d, lanes.stress[0]);
  hn::StoreU(trial.stress2, d, lanes.stress[1]);
  hn::StoreU(trial.energy, d, lanes.energy);
  hn::StoreU(hn::IfThenElseZero(ordinary, set(1)), d, keep);
  for (std::size_t k = 0; k < hn::Lanes(d); ++k) {
    if (keep[k] == 0) plastic += exceptional_membrane(t, law, i + k, dt, lanes, k);
  }
  trial.stress1 = hn::LoadU(d, lanes.stress[0]);
  trial.stress2 = hn::LoadU(d, lanes.stress[1]);
  trial.energy = hn::LoadU(d, lanes.energy);
}

// Exact greatest squared frequency of triangles with edges a and b, limited to `cap`, that of the reference shape
// (`shape`) compressed to a fifth.
struct Frequency {
  V squared, cap;
};
HWY_ATTR HWY_INLINE Frequency membrane_frequency(const ShellLaw& law, const Vector& a, const Vector& b,
                                                 const V (&m)[4]) {
  const D d;
  const V factor = set(1.5 * law.plane_modulus / law.density);
  const V area_factor = set(12 * (1 - law.poisson_ratio * law.poisson_ratio));
  const V aa = dot(a, a), bb = dot(b, b), ab = dot(a, b), half = hn::Sub(hn::Add(aa, bb), ab),
          lengths = hn::Add(half, half);
  const V area4 = hn::Max(hn::Sub(hn::Mul(aa, bb), hn::Mul(ab, ab)), set(kTiny));
  const V under = hn::Max(hn::Sub(hn::Mul(lengths, lengths), hn::Mul(area_factor, area4)), hn::Zero(d));
  const V now = hn::Div(hn::Mul(factor, hn::Add(lengths, hn::Sqrt(under))), area4);
  const V n1 = combine(m[0], m[0], m[1], m[1]), n2 = combine(m[2], m[2], m[3], m[3]),
          n12 = combine(m[0], m[2], m[1], m[3]);
  constexpr double squash = 4 / (kMinStretch * kMinStretch);  // the trace is twice n1 + n2 + n12
  const V cap = hn::Mul(set(squash), hn::Mul(factor, hn::Add(hn::Add(n1, n2), n12)));
  return {hn::Min(now, cap), cap};
}

// Deformation gradient F (columns) of the reference shape `m` with edges a and b.
struct Gradient {
  Vector x, y;
  HWY_ATTR HWY_INLINE Gradient(const Vector& a, const Vector& b, const V (&m)[4])
      : x(combine(a, m[0], b, m[2])), y(combine(a, m[1], b, m[3])) {}
};

// The elastic law near the reference shape; the results for larger strains are invalid and must not be used.
HWY_ATTR HWY_INLINE Trial elastic_trial(const ShellLaw& law, const Gradient& f, V& equivalent2) {
  const V half = set(0.5), modulus = set(law.plane_modulus), poisson = set(law.poisson_ratio);
  const V c11 = dot(f.x, f.x), c22 = dot(f.y, f.y);
  Trial trial;
  trial.shear = dot(f.x, f.y);
  trial.mean = hn::Mul(half, hn::Add(c11, c22));
  trial.difference = hn::Mul(half, hn::Sub(c11, c22));
  trial.radius = hn::Sqrt(combine(trial.difference, trial.difference, trial.shear, trial.shear));
  trial.mu1 = hn::Add(trial.mean, trial.radius);
  trial.mu2 = hn::Sub(trial.mean, trial.radius);
  const V e1 = near_half_log(trial.mu1), e2 = near_half_log(trial.mu2);
  const V t1 = hn::Mul(modulus, hn::Add(e1, hn::Mul(poisson, e2)));
  const V t2 = hn::Mul(modulus, hn::Add(e2, hn::Mul(poisson, e1)));
  trial.stress1 = hn::Div(t1, trial.mu1);
  trial.stress2 = hn::Div(t2, trial.mu2);
  trial.energy = hn::Mul(half, combine(t1, e1, t2, e2));
  equivalent2 = hn::Sub(combine(t1, t1, t2, t2), hn::Mul(t1, t2));
  return trial;
}

// Second Piola-Kirchhoff stress in the frame of the reference shape.
struct Stress {
  V xx, yy, xy;
};

// From the principal values only; the principal axes, which are those of F^T F, are not computed.
HWY_ATTR HWY_INLINE Stress elastic_stress(const Trial& trial) {
  const V half = set(0.5), mean = hn::Mul(half, hn::Add(trial.stress1, trial.stress2));
  const V turn = hn::Div(hn::Mul(half, hn::Sub(trial.stress1, trial.stress2)), hn::Max(trial.radius, set(kTiny)));
  const V along = hn::Mul(turn, trial.difference);
  return {hn::Add(mean, along), hn::Sub(mean, along), hn::Mul(turn, trial.shear)};
}

// Viscosity as a constant fraction of critical damping, scaled so that large stretches do not increase it. Adds to
// `stress` and returns the power per volume at rest. `w`: rate of F; `mean`: half the trace of F^T F.
HWY_ATTR HWY_INLINE V add_viscosity(const ShellLaw& law, const Gradient& f, const Gradient& w, V mean,
                                    const Frequency& frequency, Stress& stress) {
  const V min = hn::Mul(frequency.cap, set(1e-4)), poisson = set(law.poisson_ratio), wide = hn::Max(mean, set(1));
  const V time = hn::Div(set(2 * kShellDamping), hn::Sqrt(hn::Max(frequency.squared, min)));
  const V viscous = hn::Div(hn::Mul(set(law.plane_modulus), time), hn::Mul(wide, wide));
  const V xx = dot(f.x, w.x), yy = dot(f.y, w.y), xy = hn::Mul(set(0.5), hn::Add(dot(f.x, w.y), dot(f.y, w.x)));
  const Stress r = {hn::Mul(viscous, hn::Add(xx, hn::Mul(poisson, yy))),
                    hn::Mul(viscous, hn::Add(yy, hn::Mul(poisson, xx))),
                    hn::Mul(viscous, hn::Mul(set(1 - law.poisson_ratio), xy))};
  stress = {hn::Add(stress.xx, r.xx), hn::Add(stress.yy, r.yy), hn::Add(stress.xy, r.xy)};
  return hn::Add(combine(r.xx, xx, r.yy, yy), hn::Mul(hn::Add(r.xy, r.xy), xy));
}

HWY_ATTR void membranes(ShellTables& t, const ShellBlock& block, const ShellLaw& law, const double* copy, double dt,
                        double* forces, ShellSums& sums) {
  const D d;
  const ShellTriangles& tri = t.triangles;
  V greatest_frequency = hn::Zero(d);
  for (std::size_t i = block.triangles_begin; i < block.triangles_end; i += hn::Lanes(d)) {
    const VI index[3] = {load_index(tri.vertices[0], i), load_index(tri.vertices[1], i),
                         load_index(tri.vertices[2], i)};
    const Vector x0 = gather(copy, index[0]), v0 = gather(copy + 3, index[0]);
    const Vector a = sub(gather(copy, index[1]), x0), b = sub(gather(copy, index[2]), x0);
    const Vector va = sub(gather(copy + 3, index[1]), v0), vb = sub(gather(copy + 3, index[2]), v0);
    const V m[4] = {load(tri.shape[0], i), load(tri.shape[1], i), load(tri.shape[2], i), load(tri.shape[3], i)};
    const Gradient f(a, b, m), w(va, vb, m);
    V equivalent2;
    Trial trial = elastic_trial(law, f, equivalent2);
    const V yield = hn::Add(set(law.yield_stress), hn::Mul(set(law.hardening_modulus), load(tri.strain, i)));
    const M near = hn::And(hn::Ge(trial.mu2, set(2.0 / 3)), hn::Le(trial.mu1, set(1.5)));
    const M ordinary = hn::And(near, hn::Le(equivalent2, hn::Mul(yield, yield)));
    if (!hn::AllTrue(d, ordinary)) leave_to_scalar(t, law, i, dt, ordinary, trial, sums.plastic);
    const Frequency frequency = membrane_frequency(law, a, b, m);
    greatest_frequency = hn::Max(greatest_frequency, frequency.squared);
    Stress s = elastic_stress(trial);
    const V power = add_viscosity(law, f, w, trial.mean, frequency, s), volume = load(tri.volume, i);
    add_in_order(hn::Mul(volume, power), sums.viscous_power);
    add_in_order(hn::Mul(volume, trial.energy), sums.elastic);
    const Vector p1 = combine(f.x, s.xx, f.y, s.xy), p2 = combine(f.x, s.xy, f.y, s.yy);
    const V back = hn::Neg(volume);
    const Vector force1 = scaled(combine(p1, m[0], p2, m[1]), back);
    const Vector force2 = scaled(combine(p1, m[2], p2, m[3]), back);
    const Vector zero = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    const Vector force[3] = {sub(sub(zero, force1), force2), force1, force2};
    scatter(tri.vertices, i, force, forces);
  }
  sums.membrane = greatest(greatest_frequency);
}

HWY_ATTR HWY_NOINLINE V flow_hinges(ShellTables& t, std::size_t i, double dt, M ordinary, V moment, double& plastic) {
  const D d;
  alignas(64) double keep[kShellPadding], value[kShellPadding];
  hn::Store(hn::IfThenElseZero(ordinary, set(1)), d, keep);
  hn::Store(moment, d, value);
  for (std::size_t k = 0; k < hn::Lanes(d); ++k) {
    if (keep[k] == 0) plastic += exceptional_hinge(t, i + k, dt, value[k]);
  }
  return hn::Load(d, value);
}

// The negative gradient of a hinge's angle (Bridson et al. 2003), for the vertices of the edge and then for the
// opposite vertices. `fade` decreases from 1 to 0 as a triangle loses its area.
struct HingeGradient {
  Vector u[4];
  V fade;
};
struct HingeEdges {
  Vector edge, to02, to12, to13, to03, n1, n2;
  V length;
  HWY_ATTR HWY_INLINE HingeEdges(const double* copy, const VI (&index)[4]) {
    const Vector x0 = gather(copy, index[0]), x1 = gather(copy, index[1]);
    const Vector x2 = gather(copy, index[2]), x3 = gather(copy, index[3]);
    edge = sub(x1, x0);
    to02 = sub(x2, x0);
    to12 = sub(x2, x1);
    to13 = sub(x3, x1);
    to03 = sub(x3, x0);
    n1 = cross(to02, to12);
    n2 = cross(to13, to03);
    length = hn::Sqrt(dot(edge, edge));
  }

  /// The angle, plus the multiple of 2 pi that makes it nearest to `last`.
  HWY_ATTR HWY_INLINE V angle(V last) const {
    const V raw = angle_of(dot(cross(n1, n2), edge), hn::Mul(dot(n1, n2), length));
    const V turns = hn::Round(hn::Mul(hn::Sub(raw, last), set(0.15915494309189535)));
    return hn::Sub(raw, hn::Mul(turns, set(6.283185307179586)));
  }

  HWY_ATTR HWY_INLINE HingeGradient gradient(V min1, V min2) const {
    const V one = set(1), square1 = dot(n1, n1), square2 = dot(n2, n2);
    // The bound is far below the areas at which the moment is reduced; it prevents overflow.
    const Vector g1 = scaled(n1, hn::Div(one, hn::Max(square1, hn::Mul(min1, set(1e-8)))));
    const Vector g2 = scaled(n2, hn::Div(one, hn::Max(square2, hn::Mul(min2, set(1e-8)))));
    const V over = hn::Div(one, hn::Max(length, set(kTiny))), under = hn::Neg(over);
    HingeGradient out;
    out.u[0] = combine(g1, hn::Mul(dot(to12, edge), over), g2, hn::Mul(dot(to13, edge), over));
    out.u[1] = combine(g1, hn::Mul(dot(to02, edge), under), g2, hn::Mul(dot(to03, edge), under));
    out.u[2] = scaled(g1, length);
    out.u[3] = scaled(g2, length);
    out.fade = hn::Mul(hn::Min(one, hn::Div(square1, min1)), hn::Min(one, hn::Div(square2, min2)));
    return out;
  }
};

HWY_ATTR void hinges(ShellTables& t, const ShellBlock& block, const double* copy, double dt, double* forces,
                     ShellSums& sums) {
  const D d;
  ShellHinges& h = t.hinges;
  V frequency = hn::Zero(d), damping = hn::Zero(d);
  for (std::size_t i = block.hinges_begin; i < block.hinges_end; i += hn::Lanes(d)) {
    const VI index[4] = {load_index(h.vertices[0], i), load_index(h.vertices[1], i), load_index(h.vertices[2], i),
                         load_index(h.vertices[3], i)};
    const HingeEdges edges(copy, index);
    const V last = load(h.last, i), angle = edges.angle(last), stiffness = load(h.stiffness, i);
    const HingeGradient g = edges.gradient(load(h.min[0], i), load(h.min[1], i));
    if (dt > 0) hn::StoreU(hn::IfThenElse(hn::Ge(g.fade, set(1)), angle, last), d, h.last.data() + i);
    V offset = hn::Sub(angle, load(h.rest, i)), moment = hn::Mul(stiffness, offset);
    const M ordinary = hn::Le(hn::Abs(moment), load(h.capacity, i));
    if (!hn::AllTrue(d, ordinary)) {
      moment = flow_hinges(t, i, dt, ordinary, moment, sums.plastic);
      offset = hn::Sub(angle, load(h.rest, i));
    }
    add_in_order(hn::Mul(hn::Mul(set(0.5), moment), offset), sums.elastic);
    V rate = hn::Zero(d),
      mobility[4] = {load(h.mobility[0], i), load(h.mobility[0], i), load(h.mobility[1], i), load(h.mobility[2], i)};
    V frequency2 = hn::Zero(d);
    for (int k = 0; k < 4; ++k) {
      rate = hn::Sub(rate, dot(g.u[k], gather(copy + 3, index[k])));
      frequency2 = hn::Add(frequency2, hn::Mul(mobility[k], dot(g.u[k], g.u[k])));
    }
    frequency2 = hn::Mul(frequency2, g.fade);
    const V time = load(h.viscosity, i), viscous = hn::Mul(hn::Mul(stiffness, time), rate);
    add_in_order(hn::Mul(hn::Mul(viscous, rate), g.fade), sums.viscous_power);
    const V total = hn::Mul(hn::Add(moment, viscous), g.fade);
    const Vector force[4] = {scaled(g.u[0], total), scaled(g.u[1], total), scaled(g.u[2], total),
                             scaled(g.u[3], total)};
    scatter(h.vertices, i, force, forces);
    frequency = hn::Max(frequency, frequency2);
    damping = hn::Max(damping, hn::Mul(frequency2, time));
  }
  sums.hinge = greatest(frequency);
  sums.hinge_damping = greatest(damping);
}

void block_forces(ShellTables& tables, std::size_t index, const double* copy, double dt, double* forces) {
  const ShellBlock& block = tables.blocks[index];
  ShellSums sums;
  membranes(tables, block, tables.laws[static_cast<std::size_t>(block.object)], copy, dt, forces, sums);
  hinges(tables, block, copy, dt, forces, sums);
  tables.sums[index] = sums;
}

}  // namespace volccd::simulation::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <cmath>

#include <volccd/core/error.hpp>

namespace volccd::simulation::detail {

HWY_EXPORT(block_forces);

void add_block_forces(ShellTables& tables, std::size_t block, const double* copy, double dt, double* forces) {
  HWY_DYNAMIC_DISPATCH(block_forces)(tables, block, copy, dt, forces);
}

namespace {

void refuse_unless_finite(double value, const ShellTables& tables, Index element) {
  if (std::isfinite(value)) return;
  const Index slot = element == kNone ? kNone : tables.elements[element].slot;
  throw Error("shell element " + std::to_string(slot) + ": its deformation is not finite");
}

/// Whether plastic flow has changed the shape at rest by at most kGreatestFlow.
bool may_flow(const std::array<double, 4>& edges, const std::array<double, 4>& shape) {
  const std::array<double, 4> flow = product2(edges, shape);  // inverse of the plastic deformation
  const double mean = 0.5 * (flow[0] * flow[0] + flow[1] * flow[1] + flow[2] * flow[2] + flow[3] * flow[3]);
  const double determinant = flow[0] * flow[3] - flow[1] * flow[2];
  const double greatest2 = mean + std::sqrt(std::fmax(mean * mean - determinant * determinant, 0.0));
  const double min2 = determinant * determinant / greatest2;
  return greatest2 <= kGreatestFlow * kGreatestFlow && min2 * kGreatestFlow * kGreatestFlow >= 1;
}

}  // namespace

double exceptional_membrane(ShellTables& tables, const ShellLaw& law, std::size_t triangle, double dt,
                            MembraneLanes& lanes, std::size_t lane) {
  ShellTriangles& tri = tables.triangles;
  MembraneStep step{};
  for (std::size_t k = 0; k < 2; ++k) step.squared_stretch[k] = lanes.squared_stretch[k][lane];
  refuse_unless_finite(step.squared_stretch[0], tables, tri.element[triangle]);
  return_membrane(law, tri.strain[triangle], dt, step);
  if (step.plastic_strain > 0) {
    const double q1 = portable_exp(-step.flow[0]), q2 = portable_exp(-step.flow[1]);
    const double mean = 0.5 * (q1 + q2), turn = 0.5 * (q1 - q2) / std::fmax(lanes.radius[lane], 1e-300);
    const double along = turn * lanes.difference[lane], across = turn * lanes.shear[lane];
    std::array<double, 4> shape;
    for (std::size_t k = 0; k < 4; ++k) shape[k] = tri.shape[k][triangle];
    shape = product2(shape, {mean + along, across, across, mean - along});
    if (may_flow(tri.edges[triangle], shape)) {
      for (std::size_t k = 0; k < 4; ++k) tri.shape[k][triangle] = shape[k];
      tri.strain[triangle] += step.plastic_strain;
    } else {
      elastic_membrane(law, step);
    }
  }
  for (std::size_t k = 0; k < 2; ++k) lanes.stress[k][lane] = step.stress[k];
  lanes.energy[lane] = step.energy;
  return step.plastic_work * tri.volume[triangle];
}

double exceptional_hinge(ShellTables& tables, std::size_t hinge, double dt, double& moment) {
  ShellHinges& h = tables.hinges;
  refuse_unless_finite(moment, tables, h.elements[hinge][0]);
  if (!(dt > 0) || h.stiffness[hinge] == 0) return 0;
  const ShellLaw& law = tables.laws[static_cast<std::size_t>(h.object[hinge])];
  const double capacity = h.capacity[hinge], size = std::fabs(moment), sign = moment < 0 ? -1 : 1;
  const double angle = hinge_flow(law, {h.stiffness[hinge], size, capacity, h.slope[hinge], h.strain[hinge], dt});
  const double raise = rate_raise(law, h.strain[hinge] * angle, dt);
  h.rest[hinge] += sign * angle;
  h.capacity[hinge] += h.slope[hinge] * angle;
  moment = sign * (size - h.stiffness[hinge] * angle);
  return raise * (capacity + 0.5 * h.slope[hinge] * angle) * angle;
}

}  // namespace volccd::simulation::detail
#endif
