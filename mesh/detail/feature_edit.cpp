#include <volccd/mesh/detail/feature_edit.hpp>

#include <algorithm>

namespace volccd::detail {

void ListEdit::make_room(std::size_t size) {
  std::size_t entries = 0;
  added.group([&](Index i, std::span<const Index> values) {
    entries += lists.room_for(i, (i < lists.size() ? lists[i].size() : 0) + values.size());
  });
  lists.reserve(size, entries);
}

void ListEdit::commit(std::size_t size) noexcept {
  removed.group([&](Index i, std::span<const Index> values) { lists.erase(i, values); });
  lists.extend(size);
  added.group([&](Index i, std::span<const Index> values) { lists.insert(i, values); });
  lists.compact_if_sparse();
}

std::vector<Index> IncidenceEdit::emptied() {
  std::vector<Index> emptied;
  elements_.removed.sort();
  elements_.removed.group([&](Index i, std::span<const Index> removed) {
    const std::span<const Index> before = elements_.lists[i];
    std::size_t k = 0;
    while (k < removed.size() && removed[k] == before[k]) ++k;
    new_firsts_.push_back({i, k < before.size() ? before[k] : kNone});
    if (k == before.size()) emptied.push_back(i);
  });
  return emptied;
}

void IncidenceEdit::make_room(std::size_t features, std::vector<Index>& added, std::vector<Index>& touched) {
  elements_.added.sort();
  elements_.make_room(features);
  reserve_more(first_, features - first_.size());
  std::vector<First> remaining;
  remaining.swap(new_firsts_);
  auto next = remaining.begin();
  elements_.added.group([&](Index i, std::span<const Index> elements) {
    while (next != remaining.end() && next->feature < i) new_firsts_.push_back(*next++);
    First first{i, old_first(i)};
    if (next != remaining.end() && next->feature == i) first = *next++;
    if (first.element == kNone) added.push_back(i);
    new_firsts_.push_back({i, std::min(first.element, elements.front())});
  });
  new_firsts_.insert(new_firsts_.end(), next, remaining.end());
  for (const First& first : new_firsts_)
    if (first.element != kNone) touched.push_back(first.feature);
}

void IncidenceEdit::commit(std::size_t features) noexcept {
  elements_.commit(features);
  first_.resize(features, kNone);
  for (const First& first : new_firsts_) first_[first.feature] = first.element;
}

template <std::size_t N>
void TupleEdit<N>::erase(std::vector<Index> slots) {
  erased_slots_ = std::move(slots);
  reserve_more(free_, erased_slots_.size());
  for (const Index i : erased_slots_) {
    table_.erase(i, tuples_);
    free_.push_back(i);
    ++erased_count_;
  }
}

template <std::size_t N>
Index TupleEdit<N>::insert(const Tuple& key) {
  // All operations that may fail come first.
  reserve_more(inserted_slots_, 1);
  reserve_more(replaced_, 1);
  if (free_.empty()) reserve_more(tuples_, 1);
  const Index fresh = free_.empty() ? static_cast<Index>(tuples_.size()) : free_.back();
  const Index slot = table_.find_or_insert(key, fresh, tuples_);
  if (slot != fresh) return slot;
  if (free_.empty()) {
    tuples_.push_back(key);
  } else {
    replaced_.push_back(tuples_[slot]);
    free_.pop_back();
    tuples_[slot] = key;
  }
  inserted_slots_.push_back(slot);
  return slot;
}

/// Allocates no memory: the table and the free list have been as large before.
template <std::size_t N>
void TupleEdit<N>::undo() noexcept {
  for (std::size_t i = inserted_slots_.size(); i-- > 0;) {
    table_.erase(inserted_slots_[i], tuples_);
    if (i >= replaced_.size()) {
      tuples_.pop_back();
    } else {
      tuples_[inserted_slots_[i]] = replaced_[i];
      free_.push_back(inserted_slots_[i]);
    }
  }
  for (std::size_t i = erased_count_; i-- > 0;) {
    free_.pop_back();
    table_.find_or_insert(tuples_[erased_slots_[i]], erased_slots_[i], tuples_);
  }
}

template <std::size_t N>
void FeatureEdit::Kind<N>::remove(std::span<const Index> elements) {
  for (const Index o : elements)
    for (const Index i : of_element[o]) incident.remove(i, o);
  tuples.erase(incident.emptied());
}

template <std::size_t N>
void FeatureEdit::Kind<N>::add(Index element, const std::array<Index, N>& key) {
  of_added.push_back(tuples.insert(key));
  incident.add(of_added.back(), element);
}

template <std::size_t N>
void FeatureEdit::Kind<N>::make_room(std::span<const Index> slots, Index elements, std::vector<Index>& removed,
                                     std::vector<Index>& added, std::vector<Index>& touched) {
  removed = tuples.erased();
  incident.make_room(tuples.slots(), added, touched);
  for (const auto [i, first] : incident.new_firsts()) {
    const Index before = incident.old_first(i);
    if (before == first) continue;
    if (before != kNone) own.removed.add(before, i);
    if (first != kNone) own.added.add(first, i);
  }
  own.removed.sort();
  own.added.sort();
  own.make_room(elements);
  std::size_t entries = 0;
  for (std::size_t k = 0; k < slots.size(); ++k)
    entries += of_element.room_for(slots[k], ends[k] - (k == 0 ? 0 : ends[k - 1]));
  of_element.reserve(elements, entries);
}

template <std::size_t N>
void FeatureEdit::Kind<N>::commit(std::span<const Index> removed, std::span<const Index> slots,
                                  Index elements) noexcept {
  tuples.keep();
  incident.commit(tuples.slots());
  own.commit(elements);
  for (const Index o : removed) of_element.assign(o, {});
  of_element.extend(elements);
  for (std::size_t k = 0; k < slots.size(); ++k) {
    const std::size_t begin = k == 0 ? 0 : ends[k - 1];
    of_element.assign(slots[k], std::span(of_added).subspan(begin, ends[k] - begin));
  }
  of_element.compact_if_sparse();
}

FeatureEdit::FeatureEdit(Features& features, const Mesh& mesh, std::span<const Index> removed,
                         std::span<const ElementSpec> added, std::span<const Index> slots, Index vertices,
                         Index elements, FeatureChange& change)
    : features_(features),
      removed_(removed),
      slots_(slots.begin(), slots.end()),
      vertices_(vertices),
      elements_(elements),
      vertex_incident_(features.vertex_incidence_),
      edges_(features.edges_),
      triangles_(features.triangles_) {
  for (const Index o : removed)
    for (const Index v : mesh.vertices(o)) vertex_incident_.remove(v, o);
  change.removed_vertices = vertex_incident_.emptied();
  edges_.remove(removed);
  triangles_.remove(removed);

  std::vector<std::size_t> order(slots.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return slots[i] < slots[j]; });
  std::sort(slots_.begin(), slots_.end());
  for (const std::size_t i : order) {
    const ElementSpec& element = added[i];
    for (const Index v : element.vertices) vertex_incident_.add(v, slots[i]);
    visit_boundary(
        element.type, element.vertices.data(), element.faces, features.edge_set(),
        [&](Index a, Index b) { edges_.add(slots[i], ascending(a, b)); },
        [&](Index a, Index b, Index c) { triangles_.add(slots[i], ascending(a, b, c)); });
    edges_.ends.push_back(edges_.of_added.size());
    triangles_.ends.push_back(triangles_.of_added.size());
  }
  vertex_incident_.make_room(vertices, change.added_vertices, change.touched_vertices);
  edges_.make_room(slots_, elements, change.removed_edges, change.added_edges, change.touched_edges);
  triangles_.make_room(slots_, elements, change.removed_triangles, change.added_triangles, change.touched_triangles);
  live_vertices_ = features.live_vertices_ - static_cast<Index>(change.removed_vertices.size()) +
                   static_cast<Index>(change.added_vertices.size());
}

FeatureEdit::~FeatureEdit() = default;

void FeatureEdit::commit() noexcept {
  vertex_incident_.commit(vertices_);
  edges_.commit(removed_, slots_, elements_);
  triangles_.commit(removed_, slots_, elements_);
  features_.live_vertices_ = live_vertices_;
}

}  // namespace volccd::detail
