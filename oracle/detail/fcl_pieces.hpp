// The two questions put to FCL, in plain doubles: its headers stay in the source.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include <volccd/oracle/detail/convex_pieces.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd::detail {

/// Axis-aligned box of an element.
struct ElementBox {
  Index element;
  Vec3 low, high;
};

/// Pairs of overlapping boxes, each once, in no particular order (FCL's dynamic AABB tree).
std::vector<ElementPair> box_overlaps(std::span<const ElementBox> boxes);

/// FCL's boolean overlap query with the default libccd solver, of the convex hulls of two sets of at least three
/// points. The pair is scaled to the unit and centred first, as FCL's tolerances are absolute. Holds the shapes of FCL
/// for use again: checking their topology costs ten times a query. One thread at a time.
class FclOverlap {
 public:
  FclOverlap();
  ~FclOverlap();

  bool operator()(std::span<const Vec3> a, std::span<const Vec3> b);

 private:
  class Shapes;
  std::unique_ptr<Shapes> a_, b_;
};

}  // namespace volccd::detail
