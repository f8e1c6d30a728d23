// An edit of Features in two phases: the first may throw, the second cannot fail.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <volccd/mesh/detail/incidences.hpp>
#include <volccd/mesh/features.hpp>

namespace volccd::detail {

/// The changes of a pool's lists in an edit: (list, value) pairs to remove and to add.
struct ListEdit {
  explicit ListEdit(IncidencePool& pool) : lists(pool) {}

  /// Reserves memory for the edit and for `size` lists. Both members must have been sorted.
  void make_room(std::size_t size);
  void commit(std::size_t size) noexcept;

  IncidencePool& lists;
  Incidences removed, added;
};

/// The changes of the incident elements of one kind of feature in an edit.
class IncidenceEdit {
 public:
  struct First {
    Index feature, element;
  };

  explicit IncidenceEdit(Incidence& incidence) : first_(incidence.first), elements_(incidence.elements) {}

  /// These are called for one element after another, in ascending order.
  void remove(Index feature, Index element) { elements_.removed.add(feature, element); }
  void add(Index feature, Index element) { elements_.added.add(feature, element); }

  /// After all calls of remove(): the features that lose all of their elements, ascending.
  std::vector<Index> emptied();
  /// After all calls of add(): reserves memory for `features` features, and fills `added` and `touched` as in
  /// FeatureChange.
  void make_room(std::size_t features, std::vector<Index>& added, std::vector<Index>& touched);

  /// The first element before the edit, or kNone.
  Index old_first(Index feature) const { return feature < first_.size() ? first_[feature] : kNone; }
  /// After make_room(): the features whose elements change, ascending, each with its new first element or kNone.
  const std::vector<First>& new_firsts() const { return new_firsts_; }

  void commit(std::size_t features) noexcept;

 private:
  RawVector<Index>& first_;
  ListEdit elements_;
  std::vector<First> new_firsts_;
};

/// The changes of the slots of edges or triangles in an edit. The destructor undoes all changes unless keep() was
/// called.
template <std::size_t N>
class TupleEdit {
 public:
  using Tuple = std::array<Index, N>;

  explicit TupleEdit(TupleFeatures<N>& features)
      : tuples_(features.tuples), table_(features.table), free_(features.free) {}
  ~TupleEdit() {
    if (!kept_) undo();
  }
  TupleEdit(const TupleEdit&) = delete;
  TupleEdit& operator=(const TupleEdit&) = delete;

  /// Frees the slots of these features. To be called once, before all calls of insert().
  void erase(std::vector<Index> slots);
  /// Slot of the feature with these vertices, which is created if it does not exist.
  Index insert(const Tuple& key);

  std::size_t slots() const { return tuples_.size(); }
  const std::vector<Index>& erased() const { return erased_slots_; }
  void keep() noexcept { kept_ = true; }

 private:
  void undo() noexcept;

  RawVector<Tuple>& tuples_;
  TupleTable<N>& table_;
  std::vector<Index>& free_;
  std::vector<Index> erased_slots_;
  std::vector<Index> inserted_slots_;  ///< in the order of insertion
  std::vector<Tuple> replaced_;        ///< former contents of those of inserted_slots_ that were free before (the first
                                       ///< ones)
  std::size_t erased_count_ = 0;
  bool kept_ = false;
};

/// The constructor allocates all memory. The features must not be used until commit(), which cannot fail. If the edit
/// is destroyed without commit(), the features are unchanged.
class FeatureEdit {
 public:
  /// Removes the elements in the slots `removed` (ascending) of `mesh`, which has not been edited yet. The elements
  /// `added` take the slots `slots`, which are distinct and empty after the removals. Afterwards the mesh has
  /// `vertices` vertices and `elements` element slots. `removed` must outlive the edit. `change` must be empty; the
  /// constructor fills it. The expected time is proportional to the number of features of those elements and the
  /// lengths of their incidence lists, independent of the size of the mesh.
  FeatureEdit(Features& features, const Mesh& mesh, std::span<const Index> removed, std::span<const ElementSpec> added,
              std::span<const Index> slots, Index vertices, Index elements, FeatureChange& change);
  ~FeatureEdit();

  /// Afterwards the features are the same as after Features::build() for the edited mesh, except for the numbering of
  /// edge and triangle slots.
  void commit() noexcept;

 private:
  template <std::size_t N>
  struct Kind {
    explicit Kind(TupleFeatures<N>& f)
        : tuples(f), incident(f.incidence), own(f.incidence.own), of_element(f.of_element) {}

    void remove(std::span<const Index> elements);
    void add(Index element, const std::array<Index, N>& key);
    void make_room(std::span<const Index> slots, Index elements, std::vector<Index>& removed, std::vector<Index>& added,
                   std::vector<Index>& touched);
    void commit(std::span<const Index> removed, std::span<const Index> slots, Index elements) noexcept;

    TupleEdit<N> tuples;
    IncidenceEdit incident;
    ListEdit own;
    IncidencePool& of_element;
    std::vector<Index> of_added;    ///< features of the added elements, one element after another
    std::vector<std::size_t> ends;  ///< end of the features of each added element in of_added
  };

  Features& features_;
  std::span<const Index> removed_;
  std::vector<Index> slots_;  ///< slots of the added elements, ascending
  Index vertices_, elements_, live_vertices_;
  IncidenceEdit vertex_incident_;
  Kind<2> edges_;
  Kind<3> triangles_;
};

}  // namespace volccd::detail
