// An edit of Features in two parts: what may fail, and what may not.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <volccd/mesh/detail/incidences.hpp>
#include <volccd/mesh/features.hpp>

namespace volccd::detail {

/// Lists of a pool in an edit: (list, value) pairs that leave and that enter.
struct ListEdit {
  explicit ListEdit(IncidencePool& pool) : lists(pool) {}

  /// Once both are sorted: room for the edit and for `size` lists.
  void make_room(std::size_t size);
  void commit(std::size_t size) noexcept;

  IncidencePool& lists;
  Incidences removed, added;
};

/// The incident elements of one kind of feature in an edit.
class IncidenceEdit {
 public:
  struct First {
    Index feature, element;
  };

  explicit IncidenceEdit(Incidence& incidence) : first_(incidence.first), elements_(incidence.elements) {}

  /// Element by element, elements ascending.
  void remove(Index feature, Index element) { elements_.removed.add(feature, element); }
  void add(Index feature, Index element) { elements_.added.add(feature, element); }

  /// After all remove(): the features that lose all of their elements, ascending.
  std::vector<Index> emptied();
  /// After all add(): makes room for `features` features. Lists `added` and `touched` as FeatureChange has them.
  void make_room(std::size_t features, std::vector<Index>& added, std::vector<Index>& touched);

  /// First element before the edit, or kNone.
  Index old_first(Index feature) const { return feature < first_.size() ? first_[feature] : kNone; }
  /// After make_room(): the first element, or kNone, that each feature whose elements change will have; features ascend.
  const std::vector<First>& new_firsts() const { return new_firsts_; }

  void commit(std::size_t features) noexcept;

 private:
  std::vector<Index>& first_;
  ListEdit elements_;
  std::vector<First> new_firsts_;
};

/// The slots of edges or triangles in an edit. What it does is undone when it is destroyed, unless keep() has been
/// called.
template <std::size_t N>
class TupleEdit {
 public:
  using Tuple = std::array<Index, N>;

  TupleEdit(std::vector<Tuple>& tuples, TupleTable<N>& table, std::vector<Index>& free)
      : tuples_(tuples), table_(table), free_(free) {}
  ~TupleEdit() {
    if (!kept_) undo();
  }
  TupleEdit(const TupleEdit&) = delete;
  TupleEdit& operator=(const TupleEdit&) = delete;

  /// Once, before all insert(). The slots of these features become free.
  void erase(std::vector<Index> slots);
  /// Slot of the feature with these vertices; a new one if there is none.
  Index insert(const Tuple& key);

  std::size_t slots() const { return tuples_.size(); }
  const std::vector<Index>& erased() const { return erased_slots_; }
  void keep() noexcept { kept_ = true; }

 private:
  void undo() noexcept;

  std::vector<Tuple>& tuples_;
  TupleTable<N>& table_;
  std::vector<Index>& free_;
  std::vector<Index> erased_slots_;
  std::vector<Index> inserted_slots_;  ///< in the order in which they were inserted
  std::vector<Tuple> replaced_;  ///< what stood in the slots of the first of inserted_slots_: those that were free
  std::size_t erased_count_ = 0;
  bool kept_ = false;
};

/// The constructor does all that needs memory. Until commit(), which cannot fail, the features must not be looked at;
/// without commit(), they are as before when the edit has been destroyed.
class FeatureEdit {
 public:
  /// For `removed`, ascending slots of `mesh`, which is as it was before; and elements `added` that will be in `slots`,
  /// distinct and empty once those are gone. The mesh will have `vertices` vertices and `elements` slots. Both spans
  /// outlive the edit. `change` must be empty, and tells what commit() does. Expected time proportional to the features
  /// of those elements and the length of their incidence lists, independent of the size of the mesh.
  FeatureEdit(Features& features, const Mesh& mesh, std::span<const Index> removed, std::span<const ElementSpec> added,
              std::span<const Index> slots, Index vertices, Index elements, FeatureChange& change);
  ~FeatureEdit();

  /// Equal to Features::build() of the mesh after the edit, up to the numbering of edge and triangle slots.
  void commit() noexcept;

 private:
  template <std::size_t N>
  struct Kind {
    Kind(std::vector<std::array<Index, N>>& all, TupleTable<N>& table, Incidence& incidence, std::vector<Index>& free,
         IncidencePool& by_element)
        : tuples(all, table, free), incident(incidence), own(incidence.own), of_element(by_element) {}

    void remove(std::span<const Index> elements);
    void add(Index element, const std::array<Index, N>& key);
    void make_room(std::span<const Index> slots, Index elements, std::vector<Index>& removed, std::vector<Index>& added,
                   std::vector<Index>& touched);
    void commit(std::span<const Index> removed, std::span<const Index> slots, Index elements) noexcept;

    TupleEdit<N> tuples;
    IncidenceEdit incident;
    ListEdit own;
    IncidencePool& of_element;
    std::vector<Index> of_added;    ///< features of one added element after the other
    std::vector<std::size_t> ends;  ///< of each
  };

  Features& features_;
  std::span<const Index> removed_;
  std::vector<Index> slots_;  ///< of added elements, ascending
  Index vertices_, elements_, live_vertices_;
  IncidenceEdit vertex_incident_;
  Kind<2> edges_;
  Kind<3> triangles_;
};

}  // namespace volccd::detail
