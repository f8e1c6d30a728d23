#include <volccd/query/element_subset.hpp>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <iterator>
#include <utility>

#include <volccd/query/step.hpp>

namespace volccd {

namespace {

std::uint64_t next_version() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

}  // namespace

ElementSubset::ElementSubset() : version_(next_version()) {}

void ElementSubset::clear() {
  parts_.clear();
  vertices_.clear();
  changed_.clear();
  size_ = 0;
  before_ = 0;
  version_ = next_version();
}

void ElementSubset::resize(const Mesh& mesh) {
  assert(parts_.size() <= mesh.element_slots());
  parts_.resize(mesh.element_slots(), kNoPart);
  vertices_.resize(mesh.element_slots());
  next_.clear();
}

void ElementSubset::set_part(const Mesh& mesh, Index o, std::uint8_t part) {
  const bool other_vertices = part != kNoPart && part != kWhole && set_vertices(mesh, o, part);
  if (part == parts_[o] && !other_vertices) return;
  size_ += (part != kNoPart ? 1 : 0) - (parts_[o] != kNoPart ? 1 : 0);
  parts_[o] = part;
  next_.push_back(o);
}

bool ElementSubset::set_vertices(const Mesh& mesh, Index o, std::uint8_t part) {
  const std::span<const Index> vertices = mesh.vertices(o);
  std::array<Index, 4> chosen{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < vertices.size(); ++i)
    if ((part >> i & 1) != 0) chosen[count++] = vertices[i];
  std::fill(chosen.begin() + static_cast<std::ptrdiff_t>(count), chosen.end(), chosen[0]);
  return chosen != std::exchange(vertices_[o], chosen);
}

void ElementSubset::end_change() {
  if (next_.empty()) return;
  changed_.swap(next_);
  before_ = std::exchange(version_, next_version());
}

bool ElementSubset::changes_since(std::uint64_t version, std::span<const Index>& slots) const {
  slots = {};
  if (version == version_) return true;
  if (version != before_) return false;
  slots = changed_;
  return true;
}

ElementDelta::Extent ElementDelta::sync(const Step& step) {
  const Extent extent = topology_.sync(step.topology);
  const std::uint64_t last = std::exchange(confirmed_, 0);
  synced_ = step.subset ? step.subset->version() : 0;
  changed_slots_.clear();
  std::span<const Index> slots;
  const bool known = step.subset ? step.subset->changes_since(last, slots) : last == 0;
  if (extent == Extent::everything || !known) return Extent::everything;
  std::set_union(topology_.changed_slots().begin(), topology_.changed_slots().end(), slots.begin(), slots.end(),
                 std::back_inserter(changed_slots_));
  return changed_slots_.empty() ? Extent::none : Extent::edits;
}

void ElementDelta::confirm() {
  topology_.confirm();
  confirmed_ = synced_;
}

}  // namespace volccd
