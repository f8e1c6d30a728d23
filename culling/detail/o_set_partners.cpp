#include <volccd/culling/detail/o_set_partners.hpp>

#include <limits>

namespace volccd::detail {

namespace {

constexpr std::size_t kBits = 64;  // elements of inc(a) that are looked at together

bool contains(std::span<const Index> values, Index value) {
  return std::find(values.begin(), values.end(), value) != values.end();
}

bool adjacent(const Mesh& mesh, Index a, Index b) {
  const std::span<const Index> va = mesh.vertices(a), vb = mesh.vertices(b);
  return std::any_of(va.begin(), va.end(), [&](Index v) { return contains(vb, v); });
}

std::uint64_t full(std::size_t n) { return ~std::uint64_t{0} >> (kBits - n); }

/// The element of inc(a) whose vertices outside a have the fewest elements around them.
Index pivot(const Topology& topology, std::span<const Index> vertices, std::span<const Index> inc) {
  Index best = inc[0];
  std::size_t least = std::numeric_limits<std::size_t>::max();
  for (Index o : inc) {
    std::size_t around = 0;
    for (Index w : topology.mesh().vertices(o))
      if (!contains(vertices, w)) around += topology.features().vertex_elements(w).size();
    if (around < least) {
      least = around;
      best = o;
    }
  }
  return best;
}

}  // namespace

void OSetPartners::next_mark() {
  if (mark_ >= std::numeric_limits<std::uint32_t>::max() - 3) {
    std::fill(marks_.begin(), marks_.end(), 0u);
    mark_ = 0;
  }
  mark_ += 2;
}

void OSetPartners::touch(const Mesh& mesh, std::span<const Index> inc) {
  for (std::size_t k = 0; k < inc.size(); ++k)
    for (Index w : mesh.vertices(inc[k])) {
      if (touching_[w] == 0) touched_.push_back(w);
      touching_[w] |= std::uint64_t{1} << k;
    }
}

void OSetPartners::untouch() {
  for (Index w : touched_) touching_[w] = 0;
  touched_.clear();
}

std::uint64_t OSetPartners::touched_by(const Mesh& mesh, Index o) const {
  std::uint64_t bits = 0;
  for (Index w : mesh.vertices(o)) bits |= touching_[w];
  return bits;
}

void OSetPartners::find_covering(const Topology& topology, std::span<const Index> vertices,
                                 std::span<const Index> inc) {
  const Mesh& mesh = topology.mesh();
  const Features& features = topology.features();
  next_mark();
  covering_.clear();
  for (Index w : vertices)
    for (Index o : features.vertex_elements(w))
      if (marks_[o] < mark_) {
        marks_[o] = mark_;
        covering_.push_back(o);
      }

  // The others, by the first kBits elements of inc(a); the rest of inc(a) can only take some of them out again.
  const std::size_t sure = covering_.size();
  const std::span<const Index> first = inc.first(std::min(inc.size(), kBits));
  touch(mesh, first);
  const std::uint64_t all = full(first.size());
  for (Index w : mesh.vertices(pivot(topology, vertices, inc))) {
    if (contains(vertices, w)) continue;
    for (Index o : features.vertex_elements(w)) {
      if (marks_[o] >= mark_) continue;
      const bool covering = touched_by(mesh, o) == all;
      marks_[o] = covering ? mark_ : mark_ + 1;
      if (covering) covering_.push_back(o);
    }
  }
  untouch();
  for (std::size_t k = kBits; k < inc.size() && covering_.size() > sure; k += kBits) {
    const std::span<const Index> part = inc.subspan(k, std::min(inc.size() - k, kBits));
    touch(mesh, part);
    const auto rest = covering_.begin() + static_cast<std::ptrdiff_t>(sure);
    covering_.erase(std::remove_if(rest, covering_.end(),
                                   [&](Index o) {
                                     if (touched_by(mesh, o) == full(part.size())) return false;
                                     marks_[o] = mark_ + 1;
                                     return true;
                                   }),
                    covering_.end());
    untouch();
  }
}

bool OSetPartners::some_touches_all(const Mesh& mesh, std::span<const Index> some, std::span<const Index> all) {
  return std::any_of(some.begin(), some.end(), [&](Index o) {
    return std::all_of(all.begin(), all.end(), [&](Index other) { return adjacent(mesh, o, other); });
  });
}

}  // namespace volccd::detail
