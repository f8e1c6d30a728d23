#include <volccd/query/line_distance.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volccd/query/line_distance.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace volccd::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
Index pass_near(const Motion&, const Motion&, const std::array<double, 2>&, double, Index begin, Index) {
  return begin;
}
#else
/// The control points of a vertex are in neighbouring lanes: the first one in an even lane.
Index pass_near(const Motion& motion, const Motion& lines, const std::array<double, 2>& times, double square,
                Index begin, Index end) {
  const hn::CappedTag<double, 2 * kDistanceGroup> d;
  using Lanes = hn::Vec<decltype(d)>;
  const auto group = static_cast<Index>(hn::Lanes(d) / 2);
  const Lanes limit = hn::Set(d, square), time = hn::OddEven(hn::Set(d, times[1]), hn::Set(d, times[0]));
  const auto square_away = [&](const Lanes& x, const Lanes& line) HWY_ATTR {
    const Lanes from = hn::DupEven(line), way = hn::Sub(hn::DupOdd(line), from);
    const Lanes away = hn::Sub(x, hn::Add(from, hn::Mul(time, way)));
    return hn::Mul(away, away);
  };
  Index v = begin;
  for (; end - v >= group; v += group) {
    Lanes x, y, z, line_x, line_y, line_z;
    hn::LoadInterleaved3(d, motion.at(v), x, y, z);
    hn::LoadInterleaved3(d, lines.at(v), line_x, line_y, line_z);
    const Lanes sum = hn::Add(hn::Add(square_away(x, line_x), square_away(y, line_y)), square_away(z, line_z));
    if (!hn::AllTrue(d, hn::Le(sum, limit))) break;
  }
  return v;
}
#endif

}  // namespace volccd::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volccd::detail {

HWY_EXPORT(pass_near);

Index pass_near_vertices(const Motion& motion, const Motion& lines, const std::array<double, 2>& times, double square,
                         Index begin, Index end) {
  return HWY_DYNAMIC_DISPATCH(pass_near)(motion, lines, times, square, begin, end);
}

}  // namespace volccd::detail
#endif  // HWY_ONCE
