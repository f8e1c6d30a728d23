#include <volccd/broadphase/detail/element_list.hpp>

#include <algorithm>

namespace volccd::detail {

void ElementList::truncate(std::size_t size) {
  slots_.resize(size);
  part_sizes_.resize(size);
  begins_.resize(size + 1);
  vertices_.resize(begins_.back());
}

Index ElementList::put(const Step& step, Index slot, Index* out) {
  const std::span<const Index> vertices = step.mesh().vertices(slot), part = step.part(slot);
  const bool whole = part.data() == vertices.data();
  const auto in_part = [&](Index v) { return whole || std::find(part.begin(), part.end(), v) != part.end(); };
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

void ElementList::assign(const Step& step) {
  const Mesh& mesh = step.mesh();
  clear();
  const std::size_t count = step.subset ? step.subset->size() : mesh.element_count();
  slots_.reserve(count);
  part_sizes_.reserve(count);
  begins_.reserve(count + 1);
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (step.takes_part(o)) append(step, o);
}

void ElementList::update(const Step& step, std::span<const Index> touched) {
  slots_scratch_.clear();
  for (const Index slot : slots_)
    if (slot != kNone && !std::binary_search(touched.begin(), touched.end(), slot)) slots_scratch_.push_back(slot);
  for (const Index slot : touched)
    if (step.takes_part(slot)) slots_scratch_.push_back(slot);
  clear();
  for (const Index slot : slots_scratch_) append(step, slot);
}

void ElementList::permute(std::size_t begin, std::span<const Index> order) {
  const std::size_t end = begin + order.size(), base = begins_[begin];
  slots_scratch_.assign(slots_.begin() + static_cast<std::ptrdiff_t>(begin),
                        slots_.begin() + static_cast<std::ptrdiff_t>(end));
  part_sizes_scratch_.assign(part_sizes_.begin() + static_cast<std::ptrdiff_t>(begin),
                             part_sizes_.begin() + static_cast<std::ptrdiff_t>(end));
  begins_scratch_.assign(begins_.begin() + static_cast<std::ptrdiff_t>(begin),
                         begins_.begin() + static_cast<std::ptrdiff_t>(end) + 1);
  vertices_scratch_.assign(vertices_.begin() + static_cast<std::ptrdiff_t>(base),
                           vertices_.begin() + static_cast<std::ptrdiff_t>(begins_[end]));
  std::size_t next = base;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::size_t from = order[i] - begin;
    slots_[begin + i] = slots_scratch_[from];
    part_sizes_[begin + i] = part_sizes_scratch_[from];
    begins_[begin + i] = next;
    for (std::size_t v = begins_scratch_[from]; v < begins_scratch_[from + 1]; ++v)
      vertices_[next++] = vertices_scratch_[v - base];
  }
}

std::size_t ElementList::bytes() const {
  return (slots_.capacity() + part_sizes_.capacity() + vertices_.capacity() + slots_scratch_.capacity() +
          part_sizes_scratch_.capacity() + vertices_scratch_.capacity()) *
             sizeof(Index) +
         (begins_.capacity() + begins_scratch_.capacity()) * sizeof(std::size_t);
}

}  // namespace volccd::detail
