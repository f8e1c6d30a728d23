#include <volccd/culling/detail/o_set_partners.hpp>

#include <limits>

namespace volccd::detail {

namespace {

constexpr std::size_t kBits = 64;  // elements of inc(a) that are looked at together

bool contains(std::span<const Index> values, Index value) {
  for (Index v : values)
    if (v == value) return true;
  return false;
}

bool share_vertex(std::span<const Index> a, std::span<const Index> b) {
  return std::any_of(a.begin(), a.end(), [&](Index v) { return contains(b, v); });
}

std::uint64_t full(std::size_t n) { return ~std::uint64_t{0} >> (kBits - n); }

}  // namespace

void OSetPartners::next_mark() {
  if (mark_ >= std::numeric_limits<std::uint32_t>::max() - 3) {
    std::fill(marks_.begin(), marks_.end(), 0u);
    mark_ = 0;
  }
  mark_ += 2;
}

void OSetPartners::touch(std::span<const Index> inc) {
  for (std::size_t k = 0; k < inc.size(); ++k)
    for (Index w : (*vertices_)[inc[k]]) {
      if (touching_[w] == 0) touched_.push_back(w);
      touching_[w] |= std::uint64_t{1} << k;
    }
}

void OSetPartners::untouch() {
  for (Index w : touched_) touching_[w] = 0;
  touched_.clear();
}

/// The element of inc(a) whose vertices outside a have the fewest elements around them.
Index OSetPartners::pivot(std::span<const Index> vertices, std::span<const Index> inc) const {
  Index best = inc[0];
  std::size_t least = std::numeric_limits<std::size_t>::max();
  for (Index o : inc) {
    std::size_t around = 0;
    for (Index w : (*vertices_)[o])
      if (!contains(vertices, w)) around += features_->vertex_elements(w).size();
    if (around >= least) continue;
    least = around;
    best = o;
  }
  return best;
}

void OSetPartners::find_covering(std::span<const Index> vertices, std::span<const Index> inc) {
  next_mark();
  covering_.clear();
  for (Index w : vertices)
    for (Index o : features_->vertex_elements(w))
      if (marks_[o] < mark_) {
        marks_[o] = mark_;
        covering_.push_back(o);
      }
  find_far(vertices, inc);
}

/// Those without a vertex of a, by the first kBits elements of inc(a); the rest can only take some of them out again.
void OSetPartners::find_far(std::span<const Index> vertices, std::span<const Index> inc) {
  const std::size_t near = covering_.size();
  const std::span<const Index> first = inc.first(std::min(inc.size(), kBits));
  touch(first);
  const std::uint64_t all = full(first.size());
  for (Index w : (*vertices_)[pivot(vertices, inc)]) {
    if (contains(vertices, w)) continue;
    for (Index o : features_->vertex_elements(w)) {
      if (marks_[o] >= mark_) continue;
      const bool covering = touched_by(o) == all;
      marks_[o] = covering ? mark_ : mark_ + 1;
      if (covering) covering_.push_back(o);
    }
  }
  untouch();
  for (std::size_t k = kBits; k < inc.size() && covering_.size() > near; k += kBits) {
    const std::span<const Index> part = inc.subspan(k, std::min(inc.size() - k, kBits));
    touch(part);
    const auto end = std::remove_if(covering_.begin() + static_cast<std::ptrdiff_t>(near), covering_.end(), [&](Index o) {
      if (touched_by(o) == full(part.size())) return false;
      marks_[o] = mark_ + 1;
      return true;
    });
    covering_.erase(end, covering_.end());
    untouch();
  }
}

bool OSetPartners::some_touches_all(std::span<const Index> some, std::span<const Index> all) const {
  return std::any_of(some.begin(), some.end(), [&](Index o) {
    return std::all_of(all.begin(), all.end(),
                       [&](Index other) { return share_vertex((*vertices_)[o], (*vertices_)[other]); });
  });
}

}  // namespace volccd::detail
