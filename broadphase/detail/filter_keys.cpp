#include <volccd/broadphase/detail/filter_keys.hpp>

#include <algorithm>

#include <volccd/core/sort_unique.hpp>

namespace volccd::detail {

namespace {
constexpr std::size_t kMaxTabled = 1024;
}

bool FilterKeys::update(const Step& step, bool topology_changed) {
  if (topology_changed) keys_valid_ = false;
  const bool filter_changed = !(filter_ == step.filter);
  if (filter_changed) filter_ = step.filter;
  if (trivial() || (keys_valid_ && !filter_changed)) return filter_changed;
  if (!keys_valid_) make_keys(step.topology);
  const std::size_t count = objects_.size();
  table_.resize(count <= kMaxTabled ? count * count : 0);
  for (std::size_t at = 0; at < table_.size(); ++at)
    table_[at] = filter_.allows(objects_[at / count], objects_[at % count]);
  keys_valid_ = true;
  return true;
}

void FilterKeys::make_keys(const Topology& topology) {
  const Mesh& mesh = topology.mesh();
  objects_.clear();
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.is_live(o) && (objects_.empty() || objects_.back() != mesh.object(o))) objects_.push_back(mesh.object(o));
  sort_unique(objects_);

  keys_.assign(mesh.element_slots(), kMixed);
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.is_live(o))
      keys_[o] = static_cast<std::int32_t>(std::lower_bound(objects_.begin(), objects_.end(), mesh.object(o)) -
                                           objects_.begin());
  if (!topology.objects_share_vertices()) return;
  for (Index v = 0; v < mesh.vertex_count(); ++v)
    if (topology.is_shared(v))
      for (Index o : topology.features().vertex_elements(v)) keys_[o] = kMixed;
}

}  // namespace volccd::detail
