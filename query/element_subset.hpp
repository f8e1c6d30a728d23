// A subset of the elements of a topology, and the changes in the elements that a stage processes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <volccd/core/heap_bytes.hpp>
#include <volccd/mesh/topology_delta.hpp>

namespace volccd {

/// A set of element slots, with the part of each element that is meant: all of it, or the convex hull of some of its
/// vertices. May change from step to step. Read-only use is thread-safe.
class ElementSubset {
 public:
  /// A part is given by bits: bit i is set if vertex i of the element belongs to it. 0: the element is not in the set.
  /// Only elements with at most four vertices may have a part that is not the whole element.
  static constexpr std::uint8_t kNoPart = 0, kWhole = 0xff;

  ElementSubset();
  ElementSubset(const ElementSubset&) = delete;
  ElementSubset& operator=(const ElementSubset&) = delete;

  bool contains(Index o) const { return o < parts_.size() && parts_[o] != kNoPart; }
  bool contains_whole(Index o) const { return o < parts_.size() && parts_[o] == kWhole; }
  /// The four vertices of a part that is not the whole element; the first one is repeated at the end.
  std::span<const Index> part(Index o) const { return vertices_[o]; }
  Index size() const { return size_; }

  /// Makes the set empty, for another mesh. No earlier version is known after it.
  void clear();
  /// Replaces the parts of the elements `slots` (ascending, each once): element o of the mesh is in the set with the
  /// part part_of(o), ElementSubset::kNoPart for one that is not live. Pre: since clear(), the mesh has not lost slots,
  /// and all slots whose elements changed were given.
  template <class PartOf>
  void assign(const Mesh& mesh, std::span<const Index> slots, PartOf&& part_of) {
    resize(mesh);
    for (const Index o : slots) set_part(mesh, o, part_of(o));
    end_change();
  }

  /// Never 0, and different for every object and after every change.
  std::uint64_t version() const { return version_; }
  /// Sets `slots` to the slots, ascending, that were added or removed by the change from `version` to the present
  /// version. Returns false, with `slots` empty, if `version` is neither the present version nor the previous one.
  bool changes_since(std::uint64_t version, std::span<const Index>& slots) const;

  std::size_t bytes() const { return heap_bytes(parts_, vertices_, changed_, next_); }

 private:
  void resize(const Mesh& mesh);
  void set_part(const Mesh& mesh, Index o, std::uint8_t part);
  /// Returns whether the vertices of the part have changed.
  bool set_vertices(const Mesh& mesh, Index o, std::uint8_t part);
  void end_change();

  std::vector<std::uint8_t> parts_;             ///< by slot
  std::vector<std::array<Index, 4>> vertices_;  ///< by slot, of parts that are not whole elements
  std::vector<Index> changed_, next_;
  Index size_ = 0;
  std::uint64_t version_, before_ = 0;
};

struct Step;

/// A TopologyDelta for the elements that take part in a step (Step::takes_part): an element that left or entered
/// Step::subset is treated as removed or added. Member of the state of a broad phase, with the same protocol as
/// TopologyDelta.
class ElementDelta {
 public:
  using Extent = TopologyDelta::Extent;

  Extent sync(const Step& step);
  void confirm();

  /// Slots of elements that may have begun or ceased to take part, or may have been replaced, since the last confirm().
  /// Ascending, each once.
  const std::vector<Index>& changed_slots() const { return changed_slots_; }
  std::size_t bytes() const { return heap_bytes(topology_, changed_slots_); }

 private:
  TopologyDelta topology_;
  std::uint64_t confirmed_ = 0, synced_ = 0;  ///< versions of the subset; 0: all elements
  std::vector<Index> changed_slots_;
};

}  // namespace volccd
