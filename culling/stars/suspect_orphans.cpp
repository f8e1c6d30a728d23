#include <volccd/culling/stars/suspect_orphans.hpp>

#include <algorithm>
#include <atomic>
#include <bit>
#include <utility>

#include <volccd/query/shell_neighbours.hpp>

namespace volccd::detail {

namespace {

constexpr std::size_t kPartnerBits = 64;

}  // namespace

std::span<const SuspectOrphans::Partner> SuspectOrphans::Lists::of(Index o) const {
  const Index at = place(o);
  if (at == kNone) return {};
  return std::span(partners).subspan(begins[at], begins[at + 1] - begins[at]);
}

const SuspectOrphans::Partner* SuspectOrphans::find(Index o, Index partner) const {
  for (const Partner& p : now_.of(o))
    if (p.element == partner) return &p;
  return nullptr;
}

void SuspectOrphans::update(const Topology& topology, std::span<const ElementPair> pairs, Executor& executor,
                            bool leave_out_shell_neighbours) {
  topology_ = &topology;
  const bool other =
      std::exchange(leave_out_shell_neighbours_, leave_out_shell_neighbours) != leave_out_shell_neighbours;
  const TopologyDelta::Extent changed = delta_.sync(topology);
  std::swap(now_, before_);
  if (changed == TopologyDelta::Extent::everything || other) before_.elements.clear(), before_.places.clear();
  fresh_.assign(topology.mesh().element_slots(), 0);
  near_.assign(topology.features().vertex_slots(), 0);
  // The features of elements without vertices whose elements changed, and the elements of these features, are as
  // before.
  for (const TopologyChange* change : delta_.changes())
    for (const Index v : change->features.touched_vertices)
      for (const Index o : topology.features().vertex_elements(v)) fresh_[o] = 1;
  set_partners(pairs, executor);
  renewed_.resize(now_.elements.size());
  partner_of_.resize(executor.workers());
  for (std::vector<Index>& partner_of : partner_of_) partner_of.assign(topology.mesh().element_slots(), kNone);
  executor.parallel_for(now_.elements.size(), 4 * kBlockElements, [&](std::size_t begin, std::size_t end, unsigned w) {
    for (std::size_t i = begin; i < end; ++i) {
      renewed_[i] = reuse_partner_bits(i) ? 0 : 1;
      if (renewed_[i]) find_candidates(i, partner_of_[w]);
    }
  });
  // The tests of elements a and b depend on the bits of a, of b, and of elements that have a vertex in common with
  // both. Partners are mutual: if one of these lost all of its partners, a or b has lost one, too.
  executor.parallel_for(now_.elements.size(), 64 * kBlockElements, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t i = begin; i < end; ++i)
      if (renewed_[i])
        for (const Index v : topology.mesh().vertices(now_.elements[i]))
          std::atomic_ref(near_[v]).store(1, std::memory_order_relaxed);
  });
  now_.blocks.resize(std::max(now_.blocks.size(), blocks()));
  executor.parallel_for(blocks(), 4, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t i = begin; i < end; ++i)
      fill(now_.blocks[i], i * kBlockElements, std::min((i + 1) * kBlockElements, now_.elements.size()));
  });
  delta_.confirm();
}

/// Each worker reads all pairs, and writes what belongs to its own range of slots: a pass over the pairs takes less
/// time than atomic counters would.
void SuspectOrphans::set_partners(std::span<const ElementPair> pairs, Executor& executor) {
  const std::size_t slots = fresh_.size(), ranges = executor.workers();
  const auto visit = [&](auto&& add) {
    executor.parallel_for(ranges, 1, [&](std::size_t begin, std::size_t end, unsigned) {
      const Index low = static_cast<Index>(slots * begin / ranges), high = static_cast<Index>(slots * end / ranges);
      for (const ElementPair pair : pairs) {
        if (pair.a >= low && pair.a < high) add(pair.a, pair.b);
        if (pair.b >= low && pair.b < high && pair.a != pair.b) add(pair.b, pair.a);
      }
    });
  };
  counts_.assign(slots, 0);
  visit([&](Index o, Index) { ++counts_[o]; });
  now_.elements.clear();
  now_.begins.clear();
  now_.places.assign(slots, kNone);
  std::size_t end = 0;
  for (Index o = 0; o < slots; ++o) {
    if (counts_[o] == 0) continue;
    now_.places[o] = static_cast<Index>(now_.elements.size());
    now_.elements.push_back(o);
    now_.begins.push_back(end += counts_[o]);  // the end; filling moves it to the beginning
  }
  now_.begins.push_back(end);
  now_.partners.resize(end);
  visit([&](Index o, Index partner) { now_.partners[--now_.begins[now_.places[o]]].element = partner; });
}

/// Sorts the partners of an element. If they are those of the last update and none is fresh, copies their bits from it
/// and returns true.
bool SuspectOrphans::reuse_partner_bits(std::size_t place) {
  const std::span<Partner> row =
      std::span(now_.partners).subspan(now_.begins[place], now_.begins[place + 1] - now_.begins[place]);
  std::sort(row.begin(), row.end(), [](const Partner& a, const Partner& b) { return a.element < b.element; });
  const Index o = now_.elements[place];
  const std::span<const Partner> last = before_.of(o);
  const bool same =
      std::equal(row.begin(), row.end(), last.begin(), last.end(),
                 [&](const Partner& a, const Partner& b) { return a.element == b.element && fresh_[a.element] == 0; });
  if (same) std::copy(last.begin(), last.end(), row.begin());
  return same;
}

/// Sets the bits of the partners of an element.
void SuspectOrphans::find_candidates(std::size_t place, std::vector<Index>& partner_of) {
  const Features& features = topology_->features();
  const Index o = now_.elements[place];
  const std::size_t begin = now_.begins[place], end = now_.begins[place + 1];
  for (std::size_t i = begin; i < end; ++i) partner_of[now_.partners[i].element] = o;
  const auto bits = [&](std::span<const Index> list, auto&& elements_of) {
    std::uint64_t set = 0;
    for (std::size_t i = 0; i < std::min(kPartnerBits, list.size()); ++i) {
      const std::span<const Index> elements = elements_of(list[i]);
      const bool all = std::all_of(elements.begin(), elements.end(), [&](Index x) { return partner_of[x] == o; });
      set |= std::uint64_t{all} << i;
    }
    return set;
  };
  for (std::size_t i = begin; i < end; ++i) {
    Partner& p = now_.partners[i];
    p.edges = bits(features.own_edges(p.element), [&](Index e) { return features.edge_elements(e); });
    p.triangles = bits(features.own_triangles(p.element), [&](Index f) { return features.triangle_elements(f); });
    p.vertices = bits(topology_->mesh().vertices(p.element), [&](Index v) { return features.vertex_elements(v); });
  }
}

/// Lists the orphans of the elements at the places [begin, end), or takes them from the last update.
void SuspectOrphans::fill(Block& block, std::size_t begin, std::size_t end) const {
  block.tests.clear();
  for (std::size_t i = begin; i < end; ++i) {
    block.vf[i - begin] = block.tests.vf.size();
    block.ee[i - begin] = block.tests.ee.size();
    const Index o = now_.elements[i];
    const std::span<const Index> vertices = topology_->mesh().vertices(o);
    if (before_.place(o) != kNone &&
        std::none_of(vertices.begin(), vertices.end(), [&](Index v) { return near_[v]; })) {
      keep(o, block);
      continue;
    }
    for (const Partner& partner : now_.of(o))
      if (o <= partner.element) list(o, partner.element, block.tests);
  }
  block.vf[end - begin] = block.tests.vf.size();
  block.ee[end - begin] = block.tests.ee.size();
}

/// Appends the orphans that element o had after the last update.
void SuspectOrphans::keep(Index o, Block& block) const {
  const Index place = before_.places[o];
  const Block& from = before_.blocks[place / kBlockElements];
  const std::size_t i = place % kBlockElements;
  const auto copy = [&](std::vector<FeaturePair>& to, const std::vector<FeaturePair>& all, const auto& begins) {
    to.insert(to.end(), all.begin() + static_cast<std::ptrdiff_t>(begins[i]),
              all.begin() + static_cast<std::ptrdiff_t>(begins[i + 1]));
  };
  copy(block.tests.vf, from.tests.vf, from.vf);
  copy(block.tests.ee, from.tests.ee, from.ee);
}

/// Calls visit(i) for each feature i, by its place in the list `features` of element `other`, all of whose incident
/// elements are partners of all `elements`.
template <std::uint64_t SuspectOrphans::Partner::*kSet, class Visit>
void SuspectOrphans::visit_partners(std::span<const Index> elements, std::span<const Index> features, Index other,
                                    Visit&& visit) const {
  std::uint64_t bits = ~std::uint64_t{0};
  for (std::size_t i = 0; i < elements.size() && bits != 0; ++i) {
    const Partner* const partner = find(elements[i], other);
    bits = partner ? bits & partner->*kSet : 0;
  }
  for (std::uint64_t rest = bits; rest != 0; rest &= rest - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(rest));
    if (i < features.size()) visit(features[i]);
  }
  // Only polytopes have more features than bits. Pairs that are tested without being orphans do no harm.
  for (std::size_t i = kPartnerBits; i < features.size(); ++i) visit(features[i]);
}

/// Whether the features of a pair all of whose incident elements are partners are to be tested.
bool SuspectOrphans::is_orphan(FeatureKind kind, FeaturePair pair) const {
  const Features& features = topology_->features();
  return is_test(features, kind, pair) &&
         !(leave_out_shell_neighbours_ && share_shell_vertex(kind, test_vertices(features, kind, pair)));
}

void SuspectOrphans::list(Index a, Index b, TestBatch& out) const {
  vertices_and_triangles(a, b, out);
  if (a != b) vertices_and_triangles(b, a, out);
  const Features& features = topology_->features();
  const std::span<const Index> of_a = features.own_edges(a), of_b = features.own_edges(b);
  const std::uint64_t candidates = find(b, a)->edges;
  for (std::size_t i = 0; i < of_a.size(); ++i) {
    if (i < kPartnerBits && (candidates >> i & 1) == 0) continue;
    const Index e = of_a[i];
    visit_partners<&Partner::edges>(features.edge_elements(e), of_b, b, [&](Index g) {
      if ((a != b || e < g) && is_orphan(FeatureKind::ee, {e, g})) out.ee.push_back({std::min(e, g), std::max(e, g)});
    });
  }
}

/// Lists the orphans of a vertex whose first incident element is a and a triangle whose first incident element is b.
void SuspectOrphans::vertices_and_triangles(Index a, Index b, TestBatch& out) const {
  const Features& features = topology_->features();
  const std::span<const Index> vertices = topology_->mesh().vertices(a);
  const std::uint64_t candidates = find(b, a)->vertices;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Index v = vertices[i];
    if ((i < kPartnerBits && (candidates >> i & 1) == 0) || features.first_element_of_vertex(v) != a) continue;
    visit_partners<&Partner::triangles>(features.vertex_elements(v), features.own_triangles(b), b, [&](Index f) {
      if (is_orphan(FeatureKind::vf, {v, f})) out.vf.push_back({v, f});
    });
  }
}

void SuspectOrphans::append(std::size_t block, TestBatch& out) const {
  const TestBatch& tests = now_.blocks[block].tests;
  out.vf.insert(out.vf.end(), tests.vf.begin(), tests.vf.end());
  out.ee.insert(out.ee.end(), tests.ee.begin(), tests.ee.end());
}

}  // namespace volccd::detail
