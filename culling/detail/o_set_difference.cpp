#include <volccd/culling/detail/o_set_difference.hpp>

#include <algorithm>
#include <bit>
#include <utility>

namespace volccd::detail {

namespace {

constexpr unsigned kCorners = 4;
/// Bits for elements around x; those above are for its corners.
constexpr std::size_t kPart = ElementTouch::kBits - kCorners;
constexpr std::uint64_t kCornerBits = ~std::uint64_t{0} << kPart;

/// So many elements around a candidate are fetched before it is known whether they will be looked at.
constexpr std::size_t kAhead = 3;

constexpr std::uint16_t set_of(auto... features) { return static_cast<std::uint16_t>(((1u << features) | ...)); }

constexpr std::uint16_t kApart = set_of(0);
constexpr std::uint16_t kVertices = set_of(1, 2, 4, 8);
constexpr std::uint16_t kEdges = set_of(3, 5, 6, 9, 10, 12);
constexpr std::uint16_t kTriangles = set_of(7, 11, 13, 14);

/// By set of corners: the features with no others.
constexpr auto kWithin = [] {
  std::array<std::uint16_t, 1u << kCorners> within{};
  for (unsigned corners = 0; corners < within.size(); ++corners)
    for (unsigned feature = 1; feature < within.size() - 1; ++feature)
      if ((feature & ~corners) == 0) within[corners] |= set_of(feature);
  return within;
}();

unsigned corner_count(const OSetDifference::Simplex& x) { return x[3] == x[0] ? kCorners - 1 : kCorners; }

void prefetch(std::span<const Index> values) { __builtin_prefetch(values.data()); }

/// Visits the set bits.
template <class Visit>
void for_each_bit(unsigned set, Visit&& visit) {
  for (; set != 0; set &= set - 1) visit(static_cast<unsigned>(std::countr_zero(set)));
}

void append_unique(std::vector<FeaturePair>& pairs, std::vector<FeaturePair>& out) {
  std::sort(pairs.begin(), pairs.end());
  std::unique_copy(pairs.begin(), pairs.end(), std::back_inserter(out));
}

}  // namespace

void OSetDifference::run(std::span<const Simplex> changed, TestBatch& out) {
  set_runs(changed);
  repeated_.clear();
  for (const Simplex& x : changed) {
    find_star(x);
    if (wanted_ == 0) continue;
    find_pairs(x);
    if (!candidates_.empty()) take_pairs(x, out);
  }
  touch_.clear();
  unset_runs(changed);
  append_unique(repeated_.vf, out.vf);
  append_unique(repeated_.ee, out.ee);
}

void OSetDifference::set_runs(std::span<const Simplex> changed) {
  changed_ = changed;
  runs_.clear();
  std::vector<std::pair<Index, Index>> entries;
  entries.reserve(kCorners * changed.size());
  for (Index k = 0; k < changed.size(); ++k)
    for (unsigned i = 0; i < corner_count(changed[k]); ++i) entries.push_back({changed[k][i], k});
  std::sort(entries.begin(), entries.end());
  std::size_t length = 0;
  for (const auto& [v, k] : entries) {
    if (runs_of_vertex_[v] == 0) {
      runs_.push_back(0);
      runs_of_vertex_[v] = static_cast<Index>(runs_.size());
      length = runs_.size() - 1;
    }
    runs_.push_back(k);
    ++runs_[length];
  }
}

void OSetDifference::unset_runs(std::span<const Simplex> changed) {
  for (const Simplex& x : changed)
    for (Index v : x) runs_of_vertex_[v] = 0;
}

std::span<const Index> OSetDifference::changed_at(Index v) const {
  const Index run = runs_of_vertex_[v];
  if (run == 0) return {};
  return {runs_.data() + run, runs_[run - 1]};
}

/// The slot of a live feature of x.
Index OSetDifference::slot(const Simplex& x, unsigned feature) const {
  std::array<Index, kCorners> v{};
  std::size_t n = 0;
  for_each_bit(feature, [&](unsigned i) { v[n++] = x[i]; });
  if (n == 1) return v[0];
  return n == 2 ? features_.find_edge(v[0], v[1]) : features_.find_triangle(v[0], v[1], v[2]);
}

/// Two corners are an edge of every simplex that has both, but not of every element.
OSetDifference::FeatureSet OSetDifference::common_features(const Simplex& x, Index o, unsigned corners) const {
  FeatureSet common = kWithin[corners];
  if ((common & ~kVertices) == 0 || vertices_.simplex(o)) return common;
  for_each_bit(common & ~kVertices, [&](unsigned feature) {
    const Index f = slot(x, feature);
    const bool edge = (kEdges & set_of(feature)) != 0;
    const std::span<const Index> inc = f == kNone ? std::span<const Index>()
                                       : edge     ? features_.edge_elements(f)
                                                  : features_.triangle_elements(f);
    if (std::find(inc.begin(), inc.end(), o) == inc.end()) common &= static_cast<FeatureSet>(~set_of(feature));
  });
  return common;
}

void OSetDifference::fetch(std::span<const Index> list) {
  lists_.push_back(list);
  prefetch(list);
}

void OSetDifference::find_star(const Simplex& x) {
  set_corner_bits(x);
  star_.clear();
  lists_.clear();
  wanted_ = 0;
  for (unsigned i = 0; i < corner_count(x); ++i) fetch(features_.vertex_elements(x[i]));
  for (const std::span<const Index> around : lists_)
    for (Index o : around) prefetch(vertices_[o]);
  for (unsigned i = 0; i < corner_count(x); ++i)
    for (Index o : lists_[i]) {
      if (!in_base(o)) continue;
      const auto corners = static_cast<unsigned>(touch_.of(vertices_[o]) >> kPart);
      if ((corners & ((1u << i) - 1)) != 0) continue;  // seen at an earlier corner
      star_.push_back({o, common_features(x, o, corners)});
      wanted_ |= star_.back().features;
    }
  const auto loose =
      std::partition(star_.begin(), star_.end(), [](const Star& s) { return (s.features & ~kVertices) != 0; });
  near_ = static_cast<std::size_t>(loose - star_.begin());
}

/// Leaves in candidates_ all that make pairs with features of x. They are narrowed down by some elements of the star at
/// a time. Vertices of x that are not wanted any more after the near ones, as is most often so, need no look at the
/// others.
void OSetDifference::find_pairs(const Simplex& x) {
  const std::span<const Star> near = std::span(star_).first(near_), loose = std::span(star_).subspan(near_);
  set_bits(x, near.first(std::min(near.size(), kPart)));
  find_gained();
  find_candidates();
  narrow(wanted_);
  for (std::size_t at = kPart; at < near.size() && !candidates_.empty(); at += kPart) {
    set_bits(x, near.subspan(at, std::min(near.size() - at, kPart)));
    narrow(wanted_);
  }
  const auto has_vertex = [](const Candidate& c) { return (c.features & kVertices) != 0; };
  if (std::none_of(candidates_.begin(), candidates_.end(), has_vertex)) return;
  for (std::size_t at = 0; at < loose.size(); at += kPart) {
    set_bits(x, loose.subspan(at, std::min(loose.size() - at, kPart)));
    narrow(kVertices);
  }
}

void OSetDifference::set_corner_bits(const Simplex& x) {
  touch_.clear();
  for (unsigned i = 0; i < corner_count(x); ++i) touch_.set({&x[i], 1}, std::uint64_t{1} << (kPart + i));
}

void OSetDifference::set_bits(const Simplex& x, std::span<const Star> part) {
  touch_.next_mark();
  set_corner_bits(x);
  around_.fill(0);
  for (std::size_t k = 0; k < part.size(); ++k) {
    const std::uint64_t bit = std::uint64_t{1} << k;
    touch_.set(vertices_[part[k].element], bit);
    for_each_bit(part[k].features, [&](unsigned feature) { around_[feature] |= bit; });
  }
}

/// Features of x all of whose elements (of this part of the star) are touched by something with these bits; and kApart.
OSetDifference::FeatureSet OSetDifference::covered(std::uint64_t bits) const {
  unsigned set = (bits & kCornerBits) == 0 ? kApart : 0u;
  for (unsigned feature = 1; feature < kFeatures - 1; ++feature)
    set |= unsigned{(around_[feature] & ~bits) == 0} << feature;
  return static_cast<FeatureSet>(set & (wanted_ | kApart));
}

OSetDifference::FeatureSet OSetDifference::covered_by(Index o) {
  if (!touch_.seen(o)) touch_.note(o, covered(touch_.of(vertices_[o])));
  return touch_.noted(o);
}

/// What is gained at a feature of x touches all elements around it: it is found around any one of them. Those with a
/// triangle of x are in common to most features, and have the fewest vertices to look around.
void OSetDifference::find_gained() {
  lists_.clear();
  gained_.clear();
  gained_changed_.clear();
  FeatureSet open = wanted_;
  for (const FeatureSet kind : {kTriangles, kEdges, kVertices})
    for (const Star& s : star_) {
      if ((s.features & open & kind) == 0) continue;
      open &= static_cast<FeatureSet>(~s.features);
      for (Index w : vertices_[s.element]) {
        if ((touch_.vertex(w) & kCornerBits) != 0) continue;
        fetch(features_.vertex_elements(w));
        for (Index y : changed_at(w)) add_gained(gained_changed_, y, covered(touch_.of(changed_[y])));
      }
    }
  for (const std::span<const Index> around : lists_)
    for (Index y : around) {
      prefetch(vertices_[y]);
      touch_.prefetch(y);
    }
  for (const std::span<const Index> around : lists_)
    for (Index y : around)
      if (!touch_.seen(y) && in_base(y)) add_gained(gained_, y, covered_by(y));
}

void OSetDifference::add_gained(std::vector<Gained>& list, Index y, FeatureSet covered) {
  if ((covered & kApart) != 0 && covered != kApart) list.push_back({y, covered});
}

void OSetDifference::find_candidates() {
  candidates_.clear();
  find_candidates_of_kind(
      kEdges, [&](Index y) { return features_.element_edges(y); }, [&](Index e) { return features_.edge_elements(e); });
  find_candidates_of_kind(
      kTriangles, [&](Index y) { return vertices_[y]; }, [&](Index v) { return features_.vertex_elements(v); });
  find_candidates_of_kind(
      kVertices, [&](Index y) { return features_.element_triangles(y); },
      [&](Index f) { return features_.triangle_elements(f); });
  for (const Gained& gained : gained_changed_) find_candidates_of_changed(gained);
}

/// Those of elements of B that may make a pair with a feature of x of this kind.
template <class OfElement, class Incident>
void OSetDifference::find_candidates_of_kind(FeatureSet kind, OfElement&& of_element, Incident&& incident) {
  lists_.clear();
  for (const Gained& gained : gained_)
    if ((gained.features & kind) != 0) fetch(of_element(gained.y));
  for (const std::span<const Index> list : lists_)
    for (Index b : list) touch_.prefetch_visit(b);
  touch_.next_visit();
  const std::size_t before = candidates_.size();
  auto list = lists_.begin();
  for (const Gained& gained : gained_)
    if (const auto features = static_cast<FeatureSet>(gained.features & kind); features != 0)
      for (Index b : *list++)
        if (touch_.first_visit(b)) candidates_.push_back({b, kNone, features, {}});
  for (Candidate& c : std::span(candidates_).subspan(before)) {
    c.inc = incident(c.b);
    prefetch(c.inc);
  }
}

void OSetDifference::find_candidates_of_changed(const Gained& gained) {
  const Simplex& y = changed_[gained.y];
  const auto add = [&](FeatureSet kind, Index b, auto&& incident) {
    const auto features = static_cast<FeatureSet>(gained.features & kind);
    if (features == 0 || b == kNone) return;
    const std::span<const Index> inc = incident(b);
    if (std::any_of(inc.begin(), inc.end(), [&](Index o) { return in_base(o); }))
      candidates_.push_back({b, gained.y, features, inc});
  };
  for_each_bit(kWithin[corner_count(y) == kCorners ? 15 : 7], [&](unsigned feature) {
    const Index b = slot(y, feature);
    switch (std::popcount(feature)) {
      case 1: return add(kTriangles, b, [&](Index v) { return features_.vertex_elements(v); });
      case 2: return add(kEdges, b, [&](Index e) { return features_.edge_elements(e); });
      default: return add(kVertices, b, [&](Index f) { return features_.triangle_elements(f); });
    }
  });
}

/// Keeps those candidates all of whose elements touch all elements of this part of the star around some feature of x.
/// Only the relevant features have elements in it.
void OSetDifference::narrow(FeatureSet relevant) {
  for (const Candidate& c : candidates_)
    for (Index o : c.inc.first(std::min(c.inc.size(), kAhead))) {
      prefetch(vertices_[o]);
      touch_.prefetch(o);
    }
  std::size_t kept = 0;
  for (Candidate& c : candidates_) {
    if ((c.features & relevant) != 0) {
      if (c.changed != kNone) c.features &= covered(touch_.of(changed_[c.changed]));
      for (std::size_t i = 0; i < c.inc.size() && c.features != 0; ++i)
        if (in_base(c.inc[i])) c.features &= covered_by(c.inc[i]);
    }
    if (c.features == 0) continue;
    if ((c.features & kEdges) != 0) prefetch(features_.edge(c.b));
    candidates_[kept++] = c;
  }
  candidates_.resize(kept);
}

void OSetDifference::take_pairs(const Simplex& x, TestBatch& out) {
  std::array<Index, kFeatures> slots;
  slots.fill(kNone);
  unsigned busy = 0;  // corners that other simplices of C have too
  for (unsigned i = 0; i < corner_count(x); ++i) busy |= unsigned{changed_at(x[i]).size() > 1} << i;
  for (const Candidate& c : candidates_) {
    const bool repeated = touched_by_changed(c);
    for_each_bit(c.features, [&](unsigned feature) {
      if (slots[feature] == kNone) slots[feature] = slot(x, feature);
      const Index a = slots[feature];
      TestBatch& to = repeated || (feature & ~busy) == 0 ? repeated_ : out;
      if ((kEdges & set_of(feature)) != 0) return to.ee.push_back({std::min(a, c.b), std::max(a, c.b)});
      to.vf.push_back((kVertices & set_of(feature)) != 0 ? FeaturePair{a, c.b} : FeaturePair{c.b, a});
    });
  }
}

/// Whether a simplex of C might have this feature: then it might find the pair, too.
bool OSetDifference::touched_by_changed(const Candidate& candidate) const {
  if (candidate.changed != kNone) return true;
  const auto all = [&](std::span<const Index> vertices) {
    return std::all_of(vertices.begin(), vertices.end(), [&](Index v) { return runs_of_vertex_[v] != 0; });
  };
  if ((candidate.features & kEdges) != 0) return all(features_.edge(candidate.b));
  if ((candidate.features & kVertices) != 0) return all(features_.triangle(candidate.b));
  return all({&candidate.b, 1});
}

}  // namespace volccd::detail
