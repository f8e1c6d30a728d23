// Which pairs an O-Set loses when simplices are put into a mesh, or gains when they are taken away.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/culling/detail/o_set_touch.hpp>
#include <volccd/culling/feature_culling.hpp>
#include <volccd/mesh/features.hpp>

namespace volccd::detail {

/// Let B be the elements that stay, C simplices (tetrahedra, triangles) that come or go. Of the features that elements
/// of B have, the pairs in the minimal O-Set of B, but not in that of B with C: all of the elements of B incident to a
/// and to b are adjacent, but some x of C incident to a is apart from some y of B or C incident to b, or the other way
/// round. Both changes of Section 5.1 are this one set: what goes away with C brings these pairs, what comes with C
/// ends them.
///
/// Each x is asked for the pairs of all of its features at once. If y is in B, it touches all elements of B incident to
/// a, at vertices that x does not have. For most a it must so contain the far vertices of the neighbours that x has
/// there: few y are left to look at, and often none. If y is in C and does not do so, then {a,b} is found from y.
///
/// C comes as vertices, not as elements: what has gone is in no table any more.
class OSetDifference {
 public:
  /// Vertices of an element of C; a triangle repeats its first one at the end.
  using Simplex = std::array<Index, 4>;

  /// `absent`, by element: belongs to the mesh, but not to B; empty: none. `runs_of_vertex`: room by vertex, all 0; is
  /// left so.
  OSetDifference(const Features& features, const ElementVertices& vertices, ElementTouch& touch,
                 std::span<const std::uint8_t> absent, std::vector<Index>& runs_of_vertex)
      : features_(features), vertices_(vertices), touch_(touch), absent_(absent), runs_of_vertex_(runs_of_vertex) {}

  /// Appends each pair once.
  void run(std::span<const Simplex> changed, TestBatch& out);

 private:
  /// Features of x go by the set of corners of x that they have: bit i for corner i. This is a set of them, bit f for
  /// feature f; 0 is no feature, its bit says of an element that it is apart from x.
  using FeatureSet = std::uint16_t;
  static constexpr std::size_t kFeatures = 16;

  /// An element of B with a vertex of x.
  struct Star {
    Index element;
    FeatureSet features;  ///< that it has in common with x
  };
  /// An element, or simplex of C, apart from x that touches all elements around these features of x.
  struct Gained {
    Index y;
    FeatureSet features;
  };
  /// A feature of a gained y, and the features of x that it may make a pair with.
  struct Candidate {
    Index b;
    Index changed;  ///< kNone if y is in B
    FeatureSet features;
    std::span<const Index> inc;
  };

  void set_runs(std::span<const Simplex> changed);
  void unset_runs(std::span<const Simplex> changed);
  std::span<const Index> changed_at(Index v) const;

  void fetch(std::span<const Index> list);
  void find_star(const Simplex& x);
  FeatureSet common_features(const Simplex& x, Index o, unsigned corners) const;
  Index slot(const Simplex& x, unsigned feature) const;
  void set_corner_bits(const Simplex& x);
  void set_bits(const Simplex& x, std::span<const Star> part);
  FeatureSet covered(std::uint64_t bits) const;
  FeatureSet covered_by(Index o);

  void find_pairs(const Simplex& x);
  void find_gained();
  static void add_gained(std::vector<Gained>& list, Index y, FeatureSet covered);
  void find_candidates();
  template <class OfElement, class Incident>
  void find_candidates_of_kind(FeatureSet kind, OfElement&& of_element, Incident&& incident);
  void find_candidates_of_changed(const Gained& gained);
  void narrow(FeatureSet relevant);
  void take_pairs(const Simplex& x, TestBatch& out);
  bool touched_by_changed(const Candidate& candidate) const;

  bool in_base(Index o) const { return absent_.empty() || absent_[o] == 0; }

  const Features& features_;
  const ElementVertices& vertices_;
  ElementTouch& touch_;
  std::span<const std::uint8_t> absent_;
  std::vector<Index>& runs_of_vertex_;  ///< by vertex: 1 + start of its run in runs_; 0: none
  std::vector<Index> runs_;             ///< by vertex of C: {n, elements of C, ascending}
  std::span<const Simplex> changed_;

  /// What is looked at lies all over memory. So lists are collected first: while one comes, the next is asked for.
  std::vector<std::span<const Index>> lists_;
  // Of one x.
  std::vector<Star> star_;                         ///< first those with an edge in common
  std::size_t near_ = 0;                           ///< how many they are
  FeatureSet wanted_ = 0;                          ///< features with an element in B
  std::array<std::uint64_t, kFeatures> around_{};  ///< by feature: bits of the elements around it
  std::vector<Gained> gained_, gained_changed_;
  std::vector<Candidate> candidates_;

  TestBatch repeated_;  ///< pairs that other simplices of C may find, too
};

}  // namespace volccd::detail
