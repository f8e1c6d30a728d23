// Which elements each rank holds, and the regions by which this is decided.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <volccd/distributed/detail/home.hpp>
#include <volccd/distributed/piece_mesh.hpp>
#include <volccd/distributed/regions.hpp>

namespace volccd::distributed::detail {

/// Cuts space into regions by the centres of boxes, those in region r of weight density[r]; `density` is empty for
/// weights of 1. The same on all ranks. Collective.
Regions divide(Exchange& exchange, std::span<const MotionBox> boxes, const Regions& present,
               std::span<const double> density);

/// For each element of a rank, in CSR form, the ranks whose regions meet its box when that is greater by the part
/// `skin` of its longest side on each side; ascending.
class Targets {
 public:
  Targets() = default;
  /// `boxes`: those of the elements.
  Targets(const Home& home, std::span<const MotionBox> boxes, double skin, const Regions& regions);

  std::size_t size() const { return begins_.size() - 1; }
  std::span<const int> operator[](std::size_t i) const {
    return std::span(ranks_).subspan(begins_[i], begins_[i + 1] - begins_[i]);
  }
  /// Whether the elements, with their present boxes, meet no other regions. O(vertices) if no vertex has left its
  /// limits.
  bool cover(const Home& home, const Regions& regions) const;
  /// Whether there are a quarter more ranks than new targets would have, judged by 256 elements at most.
  bool too_many(const Home& home, double skin, const Regions& regions) const;

 private:
  bool within_limits(const Home& home) const;

  std::vector<std::size_t> begins_{0};
  std::vector<int> ranks_;
  /// By vertex of Home::used(): while the boxes of all vertices are within their limits, elements with one target are
  /// in its region, and the others in the boxes for which the targets were found.
  std::vector<MotionBox> limits_;
};

/// Sends each element to its targets. `boxes`: their centres tell which elements are copies. A vertex is complete on
/// the ranks whose regions its box meets, because the boxes of all elements at it contain it. Collective.
ReceivedElements distribute(Exchange& exchange, const Home& home, std::span<const MotionBox> boxes,
                            const Targets& targets, const Regions& regions, double& seconds);

/// The elements of all ranks that have one of these vertices. `ids` are distinct, `owners` the ranks that give them. No
/// vertex is marked as complete. Collective.
ReceivedElements elements_at(Exchange& exchange, const Home& home, std::span<const std::int64_t> ids,
                             std::span<const int> owners, double& seconds);

}  // namespace volccd::distributed::detail
