// Which elements each rank holds, and the regions by which this is decided.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <volccd/distributed/detail/home.hpp>
#include <volccd/distributed/regions.hpp>

namespace volccd::distributed::detail {

/// The elements of a rank as received, with the owner of each of elements.vertices.
struct ReceivedElements {
  Elements elements;
  std::vector<int> owners;
  std::uint64_t copies = 0;  ///< elements whose centre is in the region of another rank
  std::uint64_t bytes = 0;   ///< from other ranks
};

/// Cuts space into regions by the centres of boxes, those in region r of weight density[r]; `density` is empty for
/// weights of 1. The same on all ranks. Collective.
Regions divide(Exchange& exchange, std::span<const Box> boxes, const Regions& present, std::span<const double> density);

/// The box that is greater by the part `skin` of its longest side on each side. Contains the box.
Box with_skin(const Box& box, double skin);

/// Number of pairs of a box and a rank whose region it meets, for boxes with skin.
std::uint64_t count_meetings(std::span<const Box> boxes, double skin, const Regions& regions);

/// Sends each element to the ranks whose regions its kept box meets. Collective.
ReceivedElements distribute(Exchange& exchange, const Home& home, std::span<const Box> boxes, std::span<const Box> kept,
                            const Regions& regions, double& seconds);

}  // namespace volccd::distributed::detail
