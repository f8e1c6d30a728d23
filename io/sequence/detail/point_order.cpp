#include <volccd/io/sequence/detail/point_order.hpp>

#include <algorithm>
#include <numeric>

#include <fmt/format.h>

namespace volccd::detail {

PointOrder::PointOrder(const SequenceLayout& layout) {
  const std::size_t n = static_cast<std::size_t>(layout.points);
  slots_.resize(n);
  std::iota(slots_.begin(), slots_.end(), Index{0});
  ids_.assign(slots_.begin(), slots_.end());
  if (!layout.point_ids) return;
  const FrameArray& array = *layout.point_ids;
  std::vector<std::int64_t> given;
  array.read(0, layout.points, given);
  std::vector<Index> points = slots_;
  // Equal ids are sorted by position, so that the error names the later one.
  std::sort(points.begin(), points.end(),
            [&](Index a, Index b) { return given[a] != given[b] ? given[a] < given[b] : a < b; });
  for (std::size_t v = 0; v < n; ++v) {
    const std::int64_t id = given[points[v]];
    if (id < 0) array.fail(0, points[v], fmt::format("the id is negative: {}", id));
    if (v > 0 && id == ids_[v - 1]) array.fail(0, points[v], fmt::format("the id {} is there twice", id));
    ids_[v] = id;
    slots_[points[v]] = static_cast<Index>(v);
  }
}

void PointOrder::check(const SequenceLayout& layout, std::size_t frame) {
  if (!layout.point_ids) return;
  const FrameArray& array = *layout.point_ids;
  if (array.first[frame] == array.first[0]) return;
  array.read(frame, layout.points, frame_ids_);
  for (std::size_t i = 0; i < frame_ids_.size(); ++i)
    if (frame_ids_[i] != ids_[slots_[i]])
      array.fail(frame, i,
                 fmt::format("the id is {} at frame {}, but {} at frame 0: the points must be the same at all frames",
                             frame_ids_[i], frame, ids_[slots_[i]]));
}

}  // namespace volccd::detail
