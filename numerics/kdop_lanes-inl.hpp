// Projections of points on the axes of a k-DOP, one axis in each lane. Included once for each instruction set by
// foreach_target.h of Highway.
#include <array>
#include <cstddef>

#include <hwy/highway.h>

#include <volccd/numerics/kdop.hpp>

#if defined(VOLCCD_KDOP_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef VOLCCD_KDOP_LANES_INL
#undef VOLCCD_KDOP_LANES_INL
#else
#define VOLCCD_KDOP_LANES_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// The axes of a k-DOP from `first` on, as many as a register has lanes. kWidth >= kK / 2 is a power of two; axes
/// beyond kK / 2 are zero.
template <int kK, int kWidth>
class KdopAxes {
 public:
  using Tag = hn::CappedTag<double, kWidth>;

  HWY_INLINE explicit KdopAxes(std::size_t first) {
    alignas(64) static constexpr auto components = by_coordinate();
    x_ = hn::Load(Tag(), components[0].data() + first);
    y_ = hn::Load(Tag(), components[1].data() + first);
    z_ = hn::Load(Tag(), components[2].data() + first);
  }

  /// Products with 1, -1 and 0 are exact, so that there is one rounding for each term after the first. Pre: the
  /// coordinates are finite.
  HWY_INLINE hn::Vec<Tag> project(const double* p) const {
    const Tag tag;
    return hn::MulAdd(hn::Set(tag, p[2]), z_, hn::MulAdd(hn::Set(tag, p[1]), y_, hn::Mul(hn::Set(tag, p[0]), x_)));
  }

 private:
  static constexpr std::array<std::array<double, kWidth>, 3> by_coordinate() {
    std::array<std::array<double, kWidth>, 3> components{};
    for (std::size_t i = 0; i < kK / 2; ++i)
      for (std::size_t c = 0; c < 3; ++c) components[c][i] = kdop_axes<kK>()[i][c];
    return components;
  }

  hn::Vec<Tag> x_, y_, z_;
};

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
