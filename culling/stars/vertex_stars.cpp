#include <volccd/culling/stars/vertex_stars.hpp>

#include <algorithm>
#include <atomic>
#include <utility>

namespace volccd::detail {

namespace {

constexpr std::size_t kVertexGrain = 4096;

/// Calls use(v) for every vertex; all workers take part.
template <class Use>
void for_vertices(const Motion& motion, Executor& executor, Use&& use) {
  executor.parallel_for(motion.vertex_count(), kVertexGrain, [&](std::size_t begin, std::size_t end, unsigned) {
    for (auto v = static_cast<Index>(begin); v < end; ++v) use(v);
  });
}

/// The step of the stars on the cut.
Step at_cut(const Step& step) {
  return {
      .topology = *step.piece.cut_stars, .motion = step.motion, .filter = step.filter, .separation = step.separation};
}

}  // namespace

/// The motion from the end of the last step to the start of this one; null if no vertex moves in it. Vertices that the
/// last step did not have do not.
const Motion* VertexStars::find_gap(const Motion& motion, Executor& executor) {
  const Index before = gap_.vertex_count();
  if (before != motion.vertex_count()) {
    Motion gap(motion.vertex_count(), 2);
    for (Index v = 0; v < gap.vertex_count(); ++v) gap.set(v, 0, v < before ? gap_.point(v, 0) : motion.point(v, 0));
    gap_ = std::move(gap);
  }
  std::atomic<bool> moved = false;
  for_vertices(gap_, executor, [&](Index v) {
    if (!moved.load(std::memory_order_relaxed) && gap_.point(v, 0) != motion.point(v, 0))
      moved.store(true, std::memory_order_relaxed);  // once, as workers share its cache line
  });
  if (!moved) return nullptr;
  for_vertices(gap_, executor, [&](Index v) { gap_.set(v, 1, motion.point(v, 0)); });
  return &gap_;
}

/// Updates the tables and, after a change, whose stars are classified with which elements.
void VertexStars::sync(const Step& step, Executor& executor) {
  const Piece& piece = step.piece;
  const bool was_cut = cut_ != nullptr;
  const TopologyDelta::Extent changed = own_.update(step.topology, executor);
  if (changed == TopologyDelta::Extent::everything) gap_ = Motion(), cut_.reset();
  if (!piece.cut_stars) cut_.reset();  // it would miss the steps until the next one with such stars
  if (piece.cut_stars && !cut_) cut_ = std::make_unique<StarClassifier>();
  const bool cut_changed = cut_ ? cut_->update(*piece.cut_stars, executor) != TopologyDelta::Extent::none : was_cut;
  if (changed == TopologyDelta::Extent::none && !cut_changed) return;
  std::vector<Index> own, cut;
  for (Index v = 0; v < step.motion.vertex_count(); ++v)
    if (own_.table().kind(v) != StarKind::unused) (cut_ && !piece.is_complete(v) ? cut : own).push_back(v);
  own_.set_judged(step, std::move(own));
  if (cut_) cut_->set_judged(at_cut(step), std::move(cut));
}

void VertexStars::update(const Step& step, Executor& executor) {
  // An update that was interrupted leaves nothing to the next one.
  if (!std::exchange(complete_, false)) own_ = StarClassifier(), cut_.reset(), gap_ = Motion();
  sync(step, executor);
  const Motion* const gap = find_gap(step.motion, executor);
  own_.classify(step, gap, executor);
  if (cut_) cut_->classify(at_cut(step), gap, executor);
  const int end = step.motion.control_points() - 1;
  for_vertices(gap_, executor, [&](Index v) { gap_.set(v, 0, step.motion.point(v, end)); });
  suspect_.assign(step.motion.vertex_count(), 0);
  suspects_.clear();
  const auto collect = [&](const StarClassifier& stars) {
    for (const Index v : stars.judged())
      if (stars.suspect(v)) suspect_[v] = 1, suspects_.push_back(v);
  };
  collect(own_);
  if (cut_) collect(*cut_);
  std::sort(suspects_.begin(), suspects_.end());
  complete_ = true;
}

}  // namespace volccd::detail
