#include <volccd/broadphase/detail/box_rows.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/broadphase/detail/box_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

std::size_t overlapping_kernel(const BoxRows& boxes, std::size_t i, std::size_t begin, std::size_t end, Index* out) {
  const hn::CappedTag<double, BoxRows::kPadding> d;
  const std::size_t lanes = hn::Lanes(d);
  const auto inside = [&](std::size_t axis, std::size_t j) HWY_ATTR {
    return hn::And(hn::Le(hn::Set(d, boxes.low(axis)[i]), hn::LoadU(d, boxes.high(axis) + j)),
                   hn::Le(hn::LoadU(d, boxes.low(axis) + j), hn::Set(d, boxes.high(axis)[i])));
  };
  std::size_t found = 0;
  for (std::size_t j = begin; j < end; j += lanes) {
    const auto x = inside(0, j);
    if (hn::AllFalse(d, x)) continue;
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::And(x, hn::And(inside(1, j), inside(2, j))), bits);
    for (std::size_t l = 0; l < lanes; ++l) {
      out[found] = static_cast<Index>(j + l);
      found += bits[0] >> l & 1;
    }
  }
  while (found > 0 && out[found - 1] >= end) --found;
  return found;
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd::detail {

HWY_EXPORT(overlapping_kernel);

void BoxRows::update(const Step& step, const ElementList& list, Executor& executor) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  size_ = list.size();
  values_.resize(6 * stride());
  const int points = step.motion.control_points();
  executor.parallel_for(size_, 1024, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t p = begin; p < end; ++p)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        double low = infinity, high = -infinity;
        for (const Index v : list.vertices(p))
          for (int c = 0; c < points; ++c) {
            const double x = step.motion.at(v)[3 * static_cast<std::size_t>(c) + axis];
            low = std::min(low, x);
            high = std::max(high, x);
          }
        if (step.separation > 0) high = std::nextafter(high + step.separation, infinity);
        values_[axis * stride() + p] = low;
        values_[(3 + axis) * stride() + p] = high;
      }
  });
  for (std::size_t row = 0; row < 6; ++row)
    std::fill_n(values_.begin() + static_cast<std::ptrdiff_t>(row * stride() + size_), kPadding,
                row < 3 ? infinity : -infinity);
}

std::size_t BoxRows::overlapping(std::size_t i, std::size_t begin, std::size_t end, Index* out) const {
  return HWY_DYNAMIC_DISPATCH(overlapping_kernel)(*this, i, begin, end, out);
}

}  // namespace volccd::detail
#endif  // HWY_ONCE
