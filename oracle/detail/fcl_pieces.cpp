#include <volccd/oracle/detail/fcl_pieces.hpp>

#include <ccd/vec3.h>
#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/narrowphase/collision.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace volccd::detail {

// A libccd in single precision has tolerances that hide overlaps of a thousandth of an element.
static_assert(sizeof(ccd_real_t) == 8);

namespace {

/// A triangle has two sides: FCL's validation wants each edge in two faces.
std::shared_ptr<const std::vector<int>> faces_of(int points) {
  static const auto triangle = std::make_shared<const std::vector<int>>(std::vector<int>{3, 0, 1, 2, 3, 0, 2, 1});
  static const auto tetrahedron = std::make_shared<const std::vector<int>>(
      std::vector<int>{3, 0, 2, 1, 3, 0, 1, 3, 3, 1, 2, 3, 3, 2, 0, 3});
  return points == 3 ? triangle : tetrahedron;
}

fcl::Convexd convex(const ConvexPiece& piece, const Vec3& centre, double scale) {
  auto vertices = std::make_shared<std::vector<Vec3>>();
  vertices->reserve(4);
  for (const Vec3& p : piece.span()) vertices->push_back((p - centre) * scale);
  return fcl::Convexd(std::move(vertices), piece.count == 3 ? 2 : 4, faces_of(piece.count));
}

bool take_pair(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* pairs) {
  const Index i = static_cast<const ElementBox*>(a->getUserData())->element;
  const Index j = static_cast<const ElementBox*>(b->getUserData())->element;
  static_cast<std::vector<ElementPair>*>(pairs)->push_back({std::min(i, j), std::max(i, j)});
  return false;
}

}  // namespace

std::vector<ElementPair> box_overlaps(std::span<const ElementBox> boxes) {
  std::vector<std::unique_ptr<fcl::CollisionObjectd>> objects;
  std::vector<fcl::CollisionObjectd*> pointers;
  objects.reserve(boxes.size());
  for (const ElementBox& box : boxes) {
    // A box is handed over as centre and sides: what rounding takes off, the margin gives back.
    const double margin = 1e-14 * std::max(box.low.cwiseAbs().maxCoeff(), box.high.cwiseAbs().maxCoeff());
    const Vec3 side = box.high - box.low + Vec3::Constant(4 * margin);
    objects.push_back(std::make_unique<fcl::CollisionObjectd>(
        std::make_shared<fcl::Boxd>(side), fcl::Matrix3d::Identity(), Vec3((box.low + box.high) / 2)));
    objects.back()->setUserData(const_cast<ElementBox*>(&box));
    pointers.push_back(objects.back().get());
  }
  std::vector<ElementPair> pairs;
  if (pointers.empty()) return pairs;
  fcl::DynamicAABBTreeCollisionManagerd tree;
  tree.registerObjects(pointers);
  tree.setup();
  tree.collide(&pairs, take_pair);
  return pairs;
}

bool fcl_overlap(const ConvexPiece& a, const ConvexPiece& b) {
  Vec3 low = a.points[0], high = low;
  for (const ConvexPiece* piece : {&a, &b})
    for (const Vec3& p : piece->span()) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  const double extent = (high - low).maxCoeff();
  if (!(extent > 1e-150)) return false;  // all in one place: shallower than FCL is asked to see
  const Vec3 centre = (low + high) / 2;
  const fcl::Convexd shape_a = convex(a, centre, 1 / extent), shape_b = convex(b, centre, 1 / extent);
  const fcl::CollisionRequestd request;  // boolean, libccd
  fcl::CollisionResultd result;
  const fcl::Transform3d identity = fcl::Transform3d::Identity();
  fcl::collide(&shape_a, identity, &shape_b, identity, request, result);
  return result.isCollision();
}

}  // namespace volccd::detail
