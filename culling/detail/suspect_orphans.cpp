#include <volccd/culling/detail/suspect_orphans.hpp>

#include <algorithm>
#include <bit>

namespace volccd::detail {

namespace {

constexpr std::size_t kPartnerBits = 64;

}  // namespace

std::span<const SuspectOrphans::Partner> SuspectOrphans::partners(Index o) const {
  const Index place = places_[o];
  if (place == kNone) return {};
  return std::span(partners_).subspan(begins_[place], begins_[place + 1] - begins_[place]);
}

const SuspectOrphans::Partner* SuspectOrphans::find(Index o, Index partner) const {
  for (const Partner& p : partners(o))
    if (p.element == partner) return &p;
  return nullptr;
}

/// Sets the bits of the partners of o.
void SuspectOrphans::find_candidates(Index o, std::vector<Index>& partner_of) {
  const Features& features = topology_->features();
  const std::size_t begin = begins_[places_[o]], end = begins_[places_[o] + 1];
  for (std::size_t i = begin; i < end; ++i) partner_of[partners_[i].element] = o;
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
    Partner& p = partners_[i];
    p.edges = bits(features.own_edges(p.element), [&](Index e) { return features.edge_elements(e); });
    p.triangles = bits(features.own_triangles(p.element), [&](Index f) { return features.triangle_elements(f); });
    p.vertices = bits(topology_->mesh().vertices(p.element), [&](Index v) { return features.vertex_elements(v); });
  }
}

void SuspectOrphans::update(const Topology& topology, std::span<const ElementPair> pairs, Executor& executor) {
  topology_ = &topology;
  const Index slots = topology.mesh().element_slots();
  elements_.clear();
  begins_.clear();
  places_.assign(slots, kNone);
  const auto count = [&](Index o) {
    if (places_[o] == kNone) {
      places_[o] = static_cast<Index>(elements_.size());
      elements_.push_back(o);
      begins_.push_back(0);
    }
    ++begins_[places_[o]];
  };
  for (const ElementPair pair : pairs) {
    count(pair.a);
    if (pair.a != pair.b) count(pair.b);
  }
  std::size_t end = 0;
  for (std::size_t& begin : begins_) begin = end += begin;  // the ends; filling moves them to the beginnings
  begins_.push_back(end);
  partners_.resize(end);
  for (const ElementPair pair : pairs) {
    partners_[--begins_[places_[pair.a]]].element = pair.b;
    if (pair.a != pair.b) partners_[--begins_[places_[pair.b]]].element = pair.a;
  }
  partner_of_.resize(executor.workers());
  for (std::vector<Index>& partner_of : partner_of_) partner_of.assign(slots, kNone);
  executor.parallel_for(elements_.size(), 4 * kBlockElements, [&](std::size_t first, std::size_t last, unsigned w) {
    for (std::size_t i = first; i < last; ++i) find_candidates(elements_[i], partner_of_[w]);
  });
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
      if ((a != b || e < g) && is_test(features, FeatureKind::ee, {e, g}))
        out.ee.push_back({std::min(e, g), std::max(e, g)});
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
      if (is_test(features, FeatureKind::vf, {v, f})) out.vf.push_back({v, f});
    });
  }
}

void SuspectOrphans::append(std::size_t block, TestBatch& out) const {
  const std::size_t end = std::min((block + 1) * kBlockElements, elements_.size());
  for (std::size_t i = block * kBlockElements; i < end; ++i)
    for (const Partner& partner : partners(elements_[i]))
      if (elements_[i] <= partner.element) list(elements_[i], partner.element, out);
}

std::size_t SuspectOrphans::bytes() const {
  std::size_t sum = (elements_.capacity() + places_.capacity()) * sizeof(Index) +
                    partners_.capacity() * sizeof(Partner) + begins_.capacity() * sizeof(std::size_t);
  for (const std::vector<Index>& partner_of : partner_of_) sum += partner_of.capacity() * sizeof(Index);
  return sum;
}

}  // namespace volccd::detail
