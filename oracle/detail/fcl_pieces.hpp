// The two queries made with FCL, with an interface in plain doubles, so that FCL's headers are included in the source
// only.
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
/// points. The pair is first scaled to unit size and centred, because FCL's tolerances are absolute. The FCL shapes are
/// kept for reuse, because constructing them costs ten times as much as a query. Not thread-safe.
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
