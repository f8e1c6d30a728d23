#include <volccd/mesh/sequence/detail/point_order.hpp>

#include <algorithm>
#include <numeric>
#include <string>

namespace volccd::detail {

PointOrder::PointOrder(const SequenceLayout& layout) {
  const std::size_t n = static_cast<std::size_t>(layout.points);
  slots_.resize(n);
  std::iota(slots_.begin(), slots_.end(), Index{0});
  if (!layout.point_ids) {
    ids_.resize(n);
    std::iota(ids_.begin(), ids_.end(), std::int64_t{0});
    return;
  }
  const StepArray& array = *layout.point_ids;
  std::vector<std::int64_t> given;
  array.data.read(array.first[0], layout.points, given);
  std::vector<Index> points = slots_;
  // Equal ids are sorted by position, so that the error names the later one.
  std::sort(points.begin(), points.end(),
            [&](Index a, Index b) { return given[a] != given[b] ? given[a] < given[b] : a < b; });
  ids_.resize(n);
  for (std::size_t v = 0; v < n; ++v) {
    const std::int64_t id = given[points[v]];
    const std::int64_t row = array.first[0] + points[v];
    if (id < 0) array.data.fail(row, "the id is negative: " + std::to_string(id));
    if (v > 0 && id == ids_[v - 1]) array.data.fail(row, "the id " + std::to_string(id) + " is there twice");
    ids_[v] = id;
    slots_[points[v]] = static_cast<Index>(v);
  }
}

void PointOrder::check(const SequenceLayout& layout, std::size_t step) {
  if (!layout.point_ids) return;
  const StepArray& array = *layout.point_ids;
  if (array.first[step] == array.first[0]) return;
  array.data.read(array.first[step], layout.points, step_ids_);
  for (std::size_t i = 0; i < step_ids_.size(); ++i)
    if (step_ids_[i] != ids_[slots_[i]])
      array.data.fail(array.first[step] + static_cast<std::int64_t>(i),
                      "the id is " + std::to_string(step_ids_[i]) + " at step " + std::to_string(step) + ", but " +
                          std::to_string(ids_[slots_[i]]) + " at step 0: the points must be the same at all steps");
}

}  // namespace volccd::detail
