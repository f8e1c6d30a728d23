#include <volccd/culling/detail/vertex_rows.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/culling/detail/vertex_rows.cpp"
#include <hwy/foreach_target.h>
#include <volccd/numerics/kdop_lanes-inl.hpp>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {
void project_points(const Motion& motion, std::size_t begin, std::size_t end, VertexRow* rows) {
  using Axes = KdopAxes<16, kRowAxisCount>;
  const hn::Rebind<float, Axes::Tag> narrow;
  for (std::size_t i = 0; i < kRowAxisCount; i += hn::Lanes(narrow)) {
    const Axes axes(i);
    for (std::size_t row = begin; row < end; ++row)
      hn::Store(hn::DemoteTo(narrow, axes.project(motion.at(0) + 3 * row)), narrow, rows[row].at + i);
  }
}

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd::detail {

HWY_EXPORT(project_points);

void project_vertices(const Motion& motion, Executor& executor, std::vector<VertexRow>& rows) {
  constexpr std::size_t grain = 2048;
  rows.resize(motion.vertex_count() * static_cast<std::size_t>(motion.control_points()));
  executor.parallel_for(rows.size(), grain, [&](std::size_t begin, std::size_t end, unsigned) {
    HWY_DYNAMIC_DISPATCH(project_points)(motion, begin, end, rows.data());
  });
}

}  // namespace volccd::detail
#endif
