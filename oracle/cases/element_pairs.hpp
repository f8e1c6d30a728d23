// Pairs of elements that contain features that touch, or nearly touch.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include <volccd/oracle/cases/attack_cases.hpp>
#include <volccd/query/roles/element_culling.hpp>

namespace volccd::cases {

/// Makes features with points around them, `count` in each set.
using ElementGenerator = std::function<Case(Choices&, FeatureKind, int control_points, std::size_t count)>;

ElementGenerator nearly_degenerate_elements(Separation separation);
/// `attacks` must outlive the generator.
ElementGenerator attacking_elements(std::span<const Attack> attacks);
/// One element lies inside the other at the start and may leave it; their features need not touch.
Case nested_elements(Choices& choices, FeatureKind kind, int control_points, std::size_t count);

/// Pairs of elements on one topology. Pair i consists of the elements 2 i and 2 i + 1, of the same type and without a
/// common vertex.
class ElementPairs {
 public:
  explicit ElementPairs(ElementType type, Index pairs = 1);

  Index size() const { return static_cast<Index>(features_.size()); }
  ElementPair pair(Index i) const { return {2 * i, 2 * i + 1}; }

  /// Makes a case for features of pair i, which are chosen at random as well. All cases of one step have the same
  /// number of control points.
  Case choose(Choices& choices, Index i, FeatureKind kind, int control_points, const ElementGenerator& generator);

  Step step(int control_points, double separation, double t_max) const {
    return {topology_, motions_[static_cast<std::size_t>(control_points - 2)], everything_, separation, t_max};
  }
  Step step(const Case& c, double t_max) const { return step(c.control_points, c.separation, t_max); }
  const Topology& topology() const { return topology_; }
  /// Whether the mask of pair i contains a feature of its case.
  bool masked(Index i, const FeatureMask& mask) const;

 private:
  struct Chosen {
    FeatureKind kind = FeatureKind::vf;
    bool swapped = false;
    std::vector<Index> sets[2];  ///< vertices of the features
  };

  Index element(Index i, std::size_t set) const {
    return 2 * i + (static_cast<Index>(set) ^ Index{features_[i].swapped});
  }
  std::vector<Index> choose_feature(Choices& choices, std::size_t vertices, Index o) const;
  bool vertex_masked(Index i, const FeatureMask& mask) const;
  bool edge_masked(Index i, std::size_t set, const FeatureMask& mask) const;

  Topology topology_;
  Motion motions_[2];  ///< of two and three control points
  ObjectFilter everything_;
  std::vector<Chosen> features_;
};

}  // namespace volccd::cases
