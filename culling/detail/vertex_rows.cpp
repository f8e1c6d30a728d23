#include <volccd/culling/detail/vertex_rows.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/culling/detail/vertex_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void project_points(const Motion& motion, std::size_t begin, std::size_t end, VertexRow* rows) {
  const hn::CappedTag<double, kRowAxisCount> tag;
  const hn::Rebind<float, decltype(tag)> narrow;
  for (std::size_t row = begin; row < end; ++row) {
    const double* const p = motion.at(0) + 3 * row;
    static_assert(kRowAxes[3][1] == 1 && kRowAxes[4][2] == 1 && kRowAxes[5][0] == 0 && kRowAxes[6][1] == -1 &&
                  kRowAxes[7][2] == -1);
    alignas(64) const double sums[kRowAxisCount] = {p[0],        p[1],        p[2],        p[0] + p[1],
                                                    p[0] + p[2], p[1] + p[2], p[0] - p[1], p[0] - p[2]};
    for (std::size_t i = 0; i < kRowAxisCount; i += hn::Lanes(tag))
      hn::Store(hn::DemoteTo(narrow, hn::Load(tag, sums + i)), narrow, rows[row].at + i);
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
