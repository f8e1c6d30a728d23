// The two questions put to FCL, in plain doubles: its headers stay in the source.
#pragma once

#include <span>
#include <vector>

#include <volccd/oracle/detail/convex_pieces.hpp>

namespace volccd::detail {

/// Axis-aligned box of an element.
struct ElementBox {
  Index element;
  Vec3 low, high;
};

/// Pairs of overlapping boxes, each once, in no particular order (FCL's dynamic AABB tree).
std::vector<ElementPair> box_overlaps(std::span<const ElementBox> boxes);

/// Whether FCL's boolean query with the default libccd solver finds the two pieces overlapping. They are centred and scaled to
/// the unit first, as its tolerances are absolute.
bool fcl_overlap(const ConvexPiece& a, const ConvexPiece& b);

}  // namespace volccd::detail
