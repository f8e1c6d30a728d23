// The parts of space that belong to the ranks.
#pragma once

#include <span>
#include <vector>

#include <volccd/query/region.hpp>

namespace volccd::distributed {

/// A k-d tree of cuts that divides space into regions, at most one for each rank. Each finite point is in exactly one
/// region: a point on a cut is in the upper one. Ranks for which there is nothing to divide have the empty region.
/// Immutable, and the same on all ranks that build it from the same points.
class Regions {
 public:
  /// All of space for rank 0 of one rank.
  Regions() : Regions({}, {}, 1) {}

  /// Divides by recursive bisection: each cut is across the longest side of the box around the points, between two of
  /// different coordinate, where the weights of both sides are nearest to the numbers of their ranks. `points`: finite;
  /// `weights`, by point: finite, >= 0. Throws ConfigError for less than one rank. O(points log(points) log(ranks)).
  Regions(std::span<const Vec3> points, std::span<const double> weights, int ranks);

  int ranks() const { return static_cast<int>(regions_.size()); }
  const Region& region(int rank) const { return regions_[static_cast<std::size_t>(rank)]; }

  /// The rank whose region contains the point. O(log ranks). Pre: no coordinate is NaN.
  int at(const Vec3& point) const;

  /// Calls visit(rank) once for each rank whose region has a common point with the box, ascending. O(log ranks) for
  /// each of them. Pre: the box is not empty.
  template <class Visit>
  void meeting(const MotionBox& box, Visit&& visit) const {
    descend(root_, box, visit);
  }

 private:
  /// A child is the index of another node or, if it is negative, the complement of a rank.
  struct Node {
    int axis;
    double cut;
    int below, above;
  };

  int divide(std::span<const Vec3> points, std::span<const double> weights, std::span<std::size_t> order,
             int first_rank, int ranks, const Region& region);

  template <class Visit>
  void descend(int child, const MotionBox& box, Visit& visit) const {
    if (child < 0) {
      visit(~child);
      return;
    }
    const Node& node = nodes_[static_cast<std::size_t>(child)];
    if (box.low[node.axis] < node.cut) descend(node.below, box, visit);
    if (box.high[node.axis] >= node.cut) descend(node.above, box, visit);
  }

  std::vector<Node> nodes_;
  std::vector<Region> regions_;
  int root_ = 0;
};

}  // namespace volccd::distributed
