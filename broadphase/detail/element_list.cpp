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
  part_sizes_.resize(size);
  begins_.resize(size + 1);
  vertices_.resize(begins_.back());
}

Index ElementList::put(const Step& step, Index slot, Index* out) {
  const std::span<const Index> vertices = step.mesh().vertices(slot), part = step.part(slot);
  if (part.data() == vertices.data()) {  // the whole element
    for (const Index v : vertices) *out++ = v;
    return static_cast<Index>(vertices.size());
  }
  const auto in_part = [&](Index v) { return std::find(part.begin(), part.end(), v) != part.end(); };
  Index* const rest = std::copy_if(vertices.begin(), vertices.end(), out, in_part);
  std::copy_if(vertices.begin(), vertices.end(), rest, [&](Index v) { return !in_part(v); });
  return static_cast<Index>(rest - out);
}

void ElementList::append(const Step& step, Index slot) {
  slots_.push_back(slot);
  vertices_.resize(vertices_.size() + step.mesh().vertices(slot).size());
  part_sizes_.push_back(put(step, slot, vertices_.data() + begins_.back()));
  begins_.push_back(vertices_.size());
}

bool ElementList::replace_part(const Step& step, std::size_t position) {
  if (!step.takes_part(slots_[position])) return false;
  const std::span<const Index> now = step.mesh().vertices(slots_[position]), listed = vertices(position);
  if (!std::is_permutation(now.begin(), now.end(), listed.begin(), listed.end())) return false;
  part_sizes_[position] = put(step, slots_[position], vertices_.data() + begins_[position]);
  return true;
}

void ElementList::assign(const Step& step, Executor& executor) {
  const Mesh& mesh = step.mesh();
  scratch_.starts.clear();
  in_element_chunks(mesh.element_slots(), scratch_.starts, executor, [&](Start& size, Index o) {
    if (!step.takes_part(o)) return;
    ++size.elements;
    size.vertices += mesh.vertices(o).size();
  });
  const Start end = add_up(scratch_.starts, {0, 0});
  slots_.resize(end.elements);
  part_sizes_.resize(end.elements);
  begins_.resize(end.elements + 1);
  vertices_.resize(end.vertices);
  in_element_chunks(mesh.element_slots(), scratch_.starts, executor, [&](Start& next, Index o) {
    if (!step.takes_part(o)) return;
    slots_[next.elements] = o;
    begins_[next.elements] = next.vertices;
    part_sizes_[next.elements] = put(step, o, vertices_.data() + next.vertices);
    ++next.elements;
    next.vertices += mesh.vertices(o).size();
  });
  begins_.back() = end.vertices;
}

void ElementList::update(const Step& step, std::span<const Index> touched) {
  scratch_.slots.clear();
  for (const Index slot : slots_)
    if (slot != kNone && !std::binary_search(touched.begin(), touched.end(), slot)) scratch_.slots.push_back(slot);
  for (const Index slot : touched)
    if (step.takes_part(slot)) scratch_.slots.push_back(slot);
  clear();
  for (const Index slot : scratch_.slots) append(step, slot);
}

void ElementList::permute(std::size_t begin, std::span<const Index> order, Scratch& scratch, Executor& executor) {
  const std::size_t count = order.size(), base = begins_[begin];
  scratch.slots.resize(count);
  scratch.part_sizes.resize(count);
  scratch.begins.resize(count + 1);
  scratch.vertices.resize(begins_[begin + count] - base);
  scratch.starts.clear();
  in_element_chunks(count, scratch.starts, executor, [&](Start& size, Index i) {
    scratch.slots[i] = slots_[begin + i];
    scratch.part_sizes[i] = part_sizes_[begin + i];
    scratch.begins[i] = begins_[begin + i];
    for (std::size_t v = begins_[begin + i]; v < begins_[begin + i + 1]; ++v) scratch.vertices[v - base] = vertices_[v];
    size.vertices += vertices(order[i]).size();
  });
  scratch.begins[count] = begins_[begin + count];
  add_up(scratch.starts, {0, base});
  in_element_chunks(count, scratch.starts, executor, [&](Start& next, Index i) {
    const std::size_t from = order[i] - begin;
    slots_[begin + i] = scratch.slots[from];
    part_sizes_[begin + i] = scratch.part_sizes[from];
    if (i > 0) begins_[begin + i] = next.vertices;  // the first does not change, and the preceding range reads it
    for (std::size_t v = scratch.begins[from]; v < scratch.begins[from + 1]; ++v)
      vertices_[next.vertices++] = scratch.vertices[v - base];
  });
}

}  // namespace volccd::detail
