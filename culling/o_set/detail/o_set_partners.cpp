#include <volccd/culling/o_set/detail/o_set_partners.hpp>

#include <limits>

namespace volccd::detail {

namespace {

constexpr std::size_t kBits = ElementTouch::kBits;

bool contains(std::span<const Index> values, Index value) {
  for (Index v : values)  // faster for these few values than std::find
    if (v == value) return true;
  return false;
}

}  // namespace

/// The element of inc(a) whose vertices outside of a have the smallest number of incident elements.
Index OSetPartners::pivot(std::span<const Index> vertices, std::span<const Index> inc) const {
  Index best = inc[0];
  std::size_t min = std::numeric_limits<std::size_t>::max();
  for (Index o : inc) {
    std::size_t around = 0;
    for (Index w : adjacency_.vertices(o))
      if (!contains(vertices, w)) around += features_.vertex_elements(w).size();
    if (around >= min) continue;
    min = around;
    best = o;
  }
  return best;
}

void OSetPartners::find_covering(std::span<const Index> vertices, std::span<const Index> inc) {
  touch_.next_mark();
  for (Index w : vertices)
    for (Index o : features_.vertex_elements(w))
      if (!touch_.seen(o)) touch_.accept(o);
  find_far(vertices, inc);
}

/// Finds the elements without a vertex of a, by their common vertices with the first kBits elements of inc(a). The
/// remaining elements of inc(a) can only remove some of them.
void OSetPartners::find_far(std::span<const Index> vertices, std::span<const Index> inc) {
  std::vector<Index>& covering = touch_.accepted_elements();
  const auto near = static_cast<std::ptrdiff_t>(covering.size());
  const std::span<const Index> first = inc.first(std::min(inc.size(), kBits));
  touch_.set_elements(adjacency_, first);
  const std::uint64_t all = ElementTouch::all(first.size());
  for (Index w : adjacency_.vertices(pivot(vertices, inc))) {
    if (contains(vertices, w)) continue;
    for (Index o : features_.vertex_elements(w)) {
      if (touch_.seen(o)) continue;
      if (touch_.of(adjacency_.vertices(o)) == all)
        touch_.accept(o);
      else
        touch_.reject(o);
    }
  }
  touch_.clear();
  for (std::size_t k = kBits; k < inc.size(); k += kBits) {
    const std::span<const Index> part = inc.subspan(k, std::min(inc.size() - k, kBits));
    touch_.set_elements(adjacency_, part);
    const auto end = std::remove_if(covering.begin() + near, covering.end(), [&](Index o) {
      const bool covers = touch_.of(adjacency_.vertices(o)) == ElementTouch::all(part.size());
      if (!covers) touch_.reject(o);
      return !covers;
    });
    covering.erase(end, covering.end());
    touch_.clear();
  }
}

bool OSetPartners::some_touches_all(std::span<const Index> some, std::span<const Index> all) const {
  return std::any_of(some.begin(), some.end(), [&](Index o) {
    return std::all_of(all.begin(), all.end(), [&](Index other) { return adjacency_.adjacent(o, other); });
  });
}

}  // namespace volccd::detail
