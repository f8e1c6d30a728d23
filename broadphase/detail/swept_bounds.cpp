#include <volccd/broadphase/detail/swept_bounds.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <chrono>
#include <cmath>
#include <limits>

#include <volccd/numerics/kdop.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/broadphase/detail/swept_bounds.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <volccd/broadphase/detail/bounds-inl.hpp>
#include <volccd/numerics/kdop_lanes-inl.hpp>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {

/// float_below (`down`) or float_above for each lane, for finite values in the range of floats.
template <bool kDown, class DD, class VD>
HWY_INLINE auto round_outward(DD dd, VD x) {
  const hn::Rebind<float, DD> df;
  const hn::RebindToSigned<decltype(df)> di;
  const auto nearest = hn::DemoteTo(df, x);
  const auto back = hn::PromoteTo(dd, nearest);
  const auto wrong = kDown ? hn::Gt(back, x) : hn::Lt(back, x);
  const auto wrong_f = hn::Gt(hn::DemoteTo(df, hn::IfThenElseZero(wrong, hn::Set(dd, 1.0))), hn::Zero(df));
  // The neighbouring float by its bits: plus one away from zero, minus one towards zero; zero becomes the smallest
  // subnormal.
  const auto bits = hn::BitCast(di, nearest);
  const auto one = hn::Set(di, 1);
  const auto away = kDown ? hn::Lt(nearest, hn::Zero(df)) : hn::Gt(nearest, hn::Zero(df));
  const auto moved = hn::BitCast(df, hn::IfThenElse(hn::RebindMask(di, away), hn::Add(bits, one), hn::Sub(bits, one)));
  const float denormal = std::numeric_limits<float>::denorm_min();
  const auto next = hn::IfThenElse(hn::Eq(nearest, hn::Zero(df)), hn::Set(df, kDown ? -denormal : denormal), moved);
  return hn::IfThenElse(wrong_f, next, nearest);
}

/// By how much bounds are widened along each axis: by `length`, and by `margin` times the greatest 1-norm of a control
/// point. Zero in the padding.
template <int kK>
struct Widening {
  static constexpr int kWidth = padded_axes(kK);
  alignas(64) double length[kWidth] = {}, margin[kWidth] = {};

  Widening(const double* length_of_terms, const double* margin_of_terms) {
    for (std::size_t i = 0; i < kK / 2; ++i) {
      length[i] = length_of_terms[axis_terms(kdop_axes<kK>()[i])];
      margin[i] = margin_of_terms[axis_terms(kdop_axes<kK>()[i])];
    }
  }
};

template <int kK>
HWY_INLINE void bound_vertex(const double* points, int control_points, const Widening<kK>& widening, float* out) {
  constexpr int kWidth = Widening<kK>::kWidth;
  using Axes = KdopAxes<kK, kWidth>;
  const typename Axes::Tag dd;
  const hn::Rebind<float, typename Axes::Tag> df;
  const auto finite = hn::Set(dd, std::numeric_limits<double>::max());
  const auto max = hn::Set(dd, static_cast<double>(std::numeric_limits<float>::max()));
  const auto clamped = [&](auto value, auto limit) HWY_ATTR { return hn::Min(hn::Max(value, hn::Neg(limit)), limit); };
  double reach = 0;
  for (int c = 0; c < control_points; ++c)
    reach = std::max(reach, std::abs(points[3 * c]) + std::abs(points[3 * c + 1]) + std::abs(points[3 * c + 2]));
  for (std::size_t i = 0; i < kWidth; i += hn::Lanes(dd)) {
    const Axes axes(i);
    auto lo = finite, hi = hn::Neg(finite);
    for (int c = 0; c < control_points; ++c) {
      const auto at = axes.project(points + 3 * c);
      lo = hn::Min(lo, at);
      hi = hn::Max(hi, at);
    }
    const auto margin = hn::Load(dd, widening.margin + i);
    const auto wider = hn::IfThenElseZero(hn::Gt(margin, hn::Zero(dd)), hn::Mul(margin, hn::Set(dd, reach)));
    const auto by = hn::Add(hn::Load(dd, widening.length + i), wider);
    // Sums that overflowed become finite by the initial values of minimum and maximum and by this operation, so that
    // inf - inf does not occur.
    lo = hn::Sub(clamped(lo, finite), by);
    hi = hn::Add(clamped(hi, finite), by);
    hn::Store(round_outward<true>(dd, clamped(lo, max)), df, out + i);
    hn::Store(round_outward<false>(dd, clamped(hi, max)), df, out + kWidth + i);
  }
}

template <int kK>
void bound_vertex_range(const Motion& motion, const double* length, const double* margin, std::size_t begin,
                        std::size_t end, BoundsTable& out) {
  const Widening<kK> widening(length, margin);
  for (std::size_t v = begin; v < end; ++v)
    bound_vertex(motion.at(static_cast<Index>(v)), motion.control_points(), widening, out.row(v));
}

/// `length` and `margin` as in Widening, for axes of one, two and three terms.
void bound_vertex_kernel(const Motion& motion, int k, const double* length, const double* margin, std::size_t begin,
                         std::size_t end, BoundsTable& out) {
  switch (k) {
    case 6: return bound_vertex_range<6>(motion, length, margin, begin, end, out);
    case 14: return bound_vertex_range<14>(motion, length, margin, begin, end, out);
    case 16: return bound_vertex_range<16>(motion, length, margin, begin, end, out);
    case 18: return bound_vertex_range<18>(motion, length, margin, begin, end, out);
    case 24: return bound_vertex_range<24>(motion, length, margin, begin, end, out);
    default: return bound_vertex_range<26>(motion, length, margin, begin, end, out);
  }
}

void bound_element_kernel(const BoundsTable& vertices, const ElementList& list, std::size_t begin, std::size_t end,
                          BoundsTable& out) {
  with_width(vertices.width(), [&](auto width) {
    for (std::size_t p = begin; p < end; ++p) {
      if (list.slot(p) == kNone)
        make_empty<width>(out.row(p));
      else
        unite_vertices<width>(vertices.row(0), list.vertices(p), out.row(p));
    }
  });
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd::detail {

HWY_EXPORT(bound_vertex_kernel);
HWY_EXPORT(bound_element_kernel);

void BoundsTable::resize(std::size_t rows, int width) {
  width_ = width;
  grow(rows, 0);
}

void BoundsTable::grow(std::size_t rows, std::size_t kept) {
  std::size_t size = rows * stride();
  if (size <= capacity_) return;
  if (kept > 0) size += size / 16;  // the first of many changes
  std::unique_ptr<float[], Free> larger(
      static_cast<float*>(::operator new (size * sizeof(float), std::align_val_t{64})));
  if (kept > 0) std::copy_n(data_.get(), kept * stride(), larger.get());
  data_ = std::move(larger);
  capacity_ = size;
}

double bound_vertices(const Step& step, int k, Executor& executor, BoundsTable& vertices) {
  const auto begun = std::chrono::steady_clock::now();
  assert(step.motion.vertex_count() == step.mesh().vertex_count());
  const std::size_t count = step.motion.vertex_count();
  vertices.resize(count, padded_axes(k));
  constexpr double infinity = std::numeric_limits<double>::infinity();
  double length[4] = {}, margin[4] = {};
  for (int terms = 1; terms <= 3; ++terms) {
    const bool widened = step.separation > 0;
    if (widened)
      length[terms] = std::nextafter(step.separation * 0.5 * std::sqrt(double(terms)) * (1 + 0x1p-50), infinity);
    margin[terms] = widened || terms == 3 ? 0x1p-51 : 0;
  }
  executor.parallel_for(count, 4096, [&](std::size_t begin, std::size_t end, unsigned) {
    HWY_DYNAMIC_DISPATCH(bound_vertex_kernel)(step.motion, k, length, margin, begin, end, vertices);
  });
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
}

void bound_elements(const BoundsTable& vertices, const ElementList& list, Executor& executor, BoundsTable& elements) {
  elements.resize(list.size(), vertices.width());
  executor.parallel_for(list.size(), 4096, [&](std::size_t begin, std::size_t end, unsigned) {
    HWY_DYNAMIC_DISPATCH(bound_element_kernel)(vertices, list, begin, end, elements);
  });
}

}  // namespace volccd::detail
#endif  // HWY_ONCE
