#include <volccd/culling/detail/o_set_difference.hpp>

namespace volccd::detail {

void OSetDifference::set_changed(std::span<const Simplex> changed, std::vector<Index>& runs_of_vertex) {
  changed_ = changed;
  runs_of_vertex_ = &runs_of_vertex;
  std::vector<std::pair<Index, Index>> entries;
  entries.reserve(4 * changed.size());
  for (Index k = 0; k < changed.size(); ++k) for_vertices(k, [&](Index v) { entries.push_back({v, k}); });
  std::sort(entries.begin(), entries.end());
  std::size_t length = 0;
  for (const auto& [v, k] : entries) {
    if (runs_of_vertex[v] == 0) {
      runs_.push_back(0);
      runs_of_vertex[v] = static_cast<Index>(runs_.size());
      length = runs_.size() - 1;
    }
    runs_.push_back(k);
    ++runs_[length];
  }
}

OSetDifference::~OSetDifference() {
  for (const Simplex& s : changed_)
    for (Index v : s) (*runs_of_vertex_)[v] = 0;
}

std::span<const Index> OSetDifference::changed_at(Index v) const {
  const Index run = (*runs_of_vertex_)[v];
  if (run == 0) return {};
  return {runs_.data() + run, runs_[run - 1]};
}

bool OSetDifference::find_gained(Index k, std::span<const Index> a, std::span<const Index> inc) {
  of_a_.clear();
  any_changed(a, [&](Index x) {
    of_a_.push_back(x);
    return false;
  });
  if (of_a_[0] != k) return false;
  base_.clear();
  for (Index o : inc)
    if (in_base(o)) base_.push_back(o);

  touch_.set_elements(vertices_, base_);
  touch_.next_mark();
  gained_.clear();
  gained_changed_.clear();
  for (Index x : of_a_) {
    touch_.set(changed_[x], kOfChanged);
    gain_apart_from_changed();
    touch_.unset(changed_[x], kOfChanged);
  }
  if (!gained_.empty() || !gained_changed_.empty()) return true;
  touch_.clear();
  return false;
}

/// What is apart from x but touches all of base_ does so at a vertex of each that x does not have.
void OSetDifference::gain_apart_from_changed() {
  const std::uint64_t all = ElementTouch::all(base_.size());
  Index pivot = kNone;
  std::size_t least = std::numeric_limits<std::size_t>::max();
  for (Index o : base_) {
    std::size_t around = 0;
    for (Index w : vertices_[o])
      if ((touch_.vertex(w) & kOfChanged) == 0) around += features_.vertex_elements(w).size();
    if (around >= least) continue;
    least = around;
    pivot = o;
  }
  for (Index w : vertices_[pivot]) {
    if ((touch_.vertex(w) & kOfChanged) != 0) continue;
    const std::span<const Index> around = features_.vertex_elements(w);
    for (Index o : around) prefetch(o);
    for (Index o : around) {
      if (touch_.accepted(o) || !in_base(o) || touch_.of(vertices_[o]) != all) continue;
      touch_.accept(o);
      gained_.push_back(o);
    }
    for (Index y : changed_at(w))
      if (touch_.of(changed_[y]) == all &&
          std::find(gained_changed_.begin(), gained_changed_.end(), y) == gained_changed_.end())
        gained_changed_.push_back(y);
  }
}

bool OSetDifference::covered(std::span<const Index> inc) {
  const std::uint64_t all = ElementTouch::all(base_.size());
  for (Index o : inc) {
    if (!in_base(o)) continue;
    if (!touch_.seen(o)) {
      if (touch_.of(vertices_[o]) == all) {
        touch_.accept(o);
      } else {
        touch_.reject(o);
      }
    }
    if (!touch_.accepted(o)) return false;
  }
  return true;
}

bool OSetDifference::apart(const Simplex& x, std::span<const Index> vertices) const {
  return std::none_of(vertices.begin(), vertices.end(),
                      [&](Index v) { return v == x[0] || v == x[1] || v == x[2] || v == x[3]; });
}

bool OSetDifference::found_from(std::span<const Index> b, std::span<const Index> inc) const {
  const auto touches_all_of_b = [&](Index x) {
    return std::none_of(inc.begin(), inc.end(),
                        [&](Index o) { return in_base(o) && apart(changed_[x], vertices_[o]); });
  };
  return any_changed(b, [&](Index y) {
    return std::any_of(base_.begin(), base_.end(), [&](Index o) { return apart(changed_[y], vertices_[o]); }) ||
           std::any_of(of_a_.begin(), of_a_.end(),
                       [&](Index x) { return apart(changed_[y], changed_[x]) && touches_all_of_b(x); });
  });
}

}  // namespace volccd::detail
