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

/// For each box, in CSR form, the ranks whose regions meet the box that is greater by the part `skin` of its longest
/// side on each side; ascending.
class Targets {
 public:
  Targets() = default;
  Targets(std::span<const MotionBox> boxes, double skin, const Regions& regions);

  std::size_t size() const { return begins_.size() - 1; }
  std::span<const int> operator[](std::size_t i) const {
    return std::span(ranks_).subspan(begins_[i], begins_[i + 1] - begins_[i]);
  }
  /// Whether these boxes, in the same order, meet no other regions.
  bool cover(std::span<const MotionBox> boxes, const Regions& regions) const;
  /// Whether there are a quarter more ranks than Targets(boxes, skin, regions) would have, judged by 1024 boxes at
  /// most.
  bool too_many(std::span<const MotionBox> boxes, double skin, const Regions& regions) const;

 private:
  std::vector<std::size_t> begins_{0};
  std::vector<int> ranks_;
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
