// Projections of points on the axes of a VertexRow. Included once for each instruction set by foreach_target.h of
// Highway.
#include <cstddef>

#include <hwy/highway.h>

#include <volccd/culling/detail/vertex_rows.hpp>

#if defined(VOLCCD_ROW_PROJECTION_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef VOLCCD_ROW_PROJECTION_INL
#undef VOLCCD_ROW_PROJECTION_INL
#else
#define VOLCCD_ROW_PROJECTION_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using ProjectionTag = hn::CappedTag<double, kRowAxisCount>;

/// The axes from `first` on, one in each lane.
class RowAxes {
 public:
  HWY_INLINE explicit RowAxes(std::size_t first) {
    alignas(64) static constexpr auto axes = row_axes_by_coordinate();
    const ProjectionTag tag;
    x_ = hn::Load(tag, axes[0].data() + first);
    y_ = hn::Load(tag, axes[1].data() + first);
    z_ = hn::Load(tag, axes[2].data() + first);
  }

  /// Rounded once: products with 1, -1 and 0 are exact, and no axis has three terms.
  HWY_INLINE hn::Vec<ProjectionTag> project(const double* p) const {
    const ProjectionTag tag;
    return hn::MulAdd(hn::Set(tag, p[2]), z_, hn::MulAdd(hn::Set(tag, p[1]), y_, hn::Mul(hn::Set(tag, p[0]), x_)));
  }

 private:
  hn::Vec<ProjectionTag> x_, y_, z_;
};

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
