// A subset of the elements of a topology, and the changes in the elements that a stage processes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <volccd/mesh/topology_delta.hpp>

namespace volccd {

/// A set of element slots that may change from step to step. Read-only use is thread-safe.
class ElementSubset {
 public:
  ElementSubset();
  ElementSubset(const ElementSubset&) = delete;
  ElementSubset& operator=(const ElementSubset&) = delete;

  bool contains(Index o) const { return o < flags_.size() && flags_[o] != 0; }
  Index size() const { return size_; }

  /// Replaces the set by all slots o < slots for which wanted(o) is true. O(slots).
  template <class Wanted>
  void assign(Index slots, Wanted&& wanted) {
    begin_change();
    flags_.resize(slots, 0);
    for (Index o = 0; o < slots; ++o)
      if (const std::uint8_t flag = wanted(o) ? 1 : 0; flag != flags_[o]) change(o, flag);
    end_change();
  }

  /// Never 0, and different for every object and after every change.
  std::uint64_t version() const { return version_; }
  /// Sets `slots` to the slots, ascending, that were added or removed by the change from `version` to the present
  /// version. Returns false, with `slots` empty, if `version` is neither the present version nor the previous one.
  bool changes_since(std::uint64_t version, std::span<const Index>& slots) const;

  std::size_t bytes() const { return flags_.capacity() + changed_.capacity() * sizeof(Index); }

 private:
  void begin_change() { next_.clear(); }
  void change(Index o, std::uint8_t flag) {
    flags_[o] = flag;
    size_ += flag != 0 ? 1 : Index{0} - 1;
    next_.push_back(o);
  }
  void end_change();

  std::vector<std::uint8_t> flags_;  ///< whether each slot is in the set
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
  std::size_t bytes() const { return topology_.bytes() + changed_slots_.capacity() * sizeof(Index); }

 private:
  TopologyDelta topology_;
  std::uint64_t confirmed_ = 0, synced_ = 0;  ///< versions of the subset; 0: all elements
  std::vector<Index> changed_slots_;
};

}  // namespace volccd
