#include <volccd/broadphase/detail/element_list.hpp>

#include <algorithm>
#include <utility>

namespace volccd::detail {

namespace {
/// Number of elements that one task lists.
constexpr std::size_t kChunk = 4096;

/// Calls body(start, i) for all i < count, ascending in each chunk, with the start of the chunk, which it may change.
template <class Body>
void in_element_chunks(std::size_t count, std::vector<ElementList::Start>& starts, Executor& executor, Body&& body) {
  starts.resize((count + kChunk - 1) / kChunk);
  executor.parallel_for(starts.size(), 1, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t c = begin; c < end; ++c) {
      ElementList::Start start = starts[c];
      for (std::size_t i = c * kChunk; i < std::min(count, (c + 1) * kChunk); ++i) body(start, static_cast<Index>(i));
      starts[c] = start;
    }
  });
}

/// Replaces the sizes of all chunks by their starts, of which the first is given. Returns the end of the last one.
ElementList::Start add_up(std::vector<ElementList::Start>& starts, ElementList::Start next) {
  for (ElementList::Start& start : starts) {
    const ElementList::Start size = std::exchange(start, next);
    next = {next.elements + size.elements, next.vertices + size.vertices};
  }
  return next;
}

}  // namespace

void ElementList::truncate(std::size_t size) {
  slots_.resize(size);
  begins_.resize(size + 1);
  vertices_.resize(begins_.back());
}

void ElementList::append(const Mesh& mesh, Index slot) {
  const std::span<const Index> vertices = mesh.vertices(slot);
  slots_.push_back(slot);
  vertices_.insert(vertices_.end(), vertices.begin(), vertices.end());
  begins_.push_back(vertices_.size());
}

void ElementList::assign(const Mesh& mesh, Executor& executor) {
  scratch_.starts.clear();
  in_element_chunks(mesh.element_slots(), scratch_.starts, executor, [&](Start& size, Index o) {
    if (!mesh.is_live(o)) return;
    ++size.elements;
    size.vertices += mesh.vertices(o).size();
  });
  const Start end = add_up(scratch_.starts, {0, 0});
  slots_.resize(end.elements);
  begins_.resize(end.elements + 1);
  vertices_.resize(end.vertices);
  in_element_chunks(mesh.element_slots(), scratch_.starts, executor, [&](Start& next, Index o) {
    if (!mesh.is_live(o)) return;
    slots_[next.elements] = o;
    begins_[next.elements] = next.vertices;
    for (const Index v : mesh.vertices(o)) vertices_[next.vertices++] = v;
    ++next.elements;
  });
  begins_.back() = end.vertices;
}

void ElementList::update(const Mesh& mesh, std::span<const Index> touched) {
  scratch_.slots.clear();
  for (const Index slot : slots_)
    if (slot != kNone && !std::binary_search(touched.begin(), touched.end(), slot)) scratch_.slots.push_back(slot);
  for (const Index slot : touched)
    if (mesh.is_live(slot)) scratch_.slots.push_back(slot);
  clear();
  for (const Index slot : scratch_.slots) append(mesh, slot);
}

void ElementList::permute(std::size_t begin, std::span<const Index> order, Scratch& scratch, Executor& executor) {
  const std::size_t count = order.size(), base = begins_[begin];
  scratch.slots.resize(count);
  scratch.begins.resize(count + 1);
  scratch.vertices.resize(begins_[begin + count] - base);
  scratch.starts.clear();
  in_element_chunks(count, scratch.starts, executor, [&](Start& size, Index i) {
    scratch.slots[i] = slots_[begin + i];
    scratch.begins[i] = begins_[begin + i];
    for (std::size_t v = begins_[begin + i]; v < begins_[begin + i + 1]; ++v) scratch.vertices[v - base] = vertices_[v];
    size.vertices += vertices(order[i]).size();
  });
  scratch.begins[count] = begins_[begin + count];
  add_up(scratch.starts, {0, base});
  in_element_chunks(count, scratch.starts, executor, [&](Start& next, Index i) {
    const std::size_t from = order[i] - begin;
    slots_[begin + i] = scratch.slots[from];
    if (i > 0) begins_[begin + i] = next.vertices;  // the first does not change, and the preceding range reads it
    for (std::size_t v = scratch.begins[from]; v < scratch.begins[from + 1]; ++v)
      vertices_[next.vertices++] = scratch.vertices[v - base];
  });
}

}  // namespace volccd::detail
