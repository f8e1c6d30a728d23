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

// A libccd in single precision would have tolerances that hide overlaps of a thousandth of an element.
static_assert(sizeof(ccd_real_t) == 8);

namespace {

bool collect_pair(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* pairs) {
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
    // FCL gets a box as centre and sides; the margin compensates for rounding.
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
  tree.collide(&pairs, collect_pair);
  return pairs;
}

/// One shape for each number of points. Its points are replaced for each query. This is possible because the topology
/// does not change, and because the points are centred, so that the interior point does not change either.
class FclOverlap::Shapes {
 public:
  const fcl::Convexd& set_points(std::span<const Vec3> points, const Vec3& mean, double scale) {
    if (shapes_.size() <= points.size()) shapes_.resize(points.size() + 1);
    Shape& shape = shapes_[points.size()];
    if (!shape.convex) {
      // The mean must already be zero here, because FCL takes it as an interior point.
      shape.points = std::make_shared<std::vector<Vec3>>(points.size(), Vec3::Zero());
      // The query uses only points. FCL may use faces to find neighbours along edges, but only if every point is on a
      // face.
      shape.convex = std::make_unique<fcl::Convexd>(
          shape.points, 2, std::make_shared<const std::vector<int>>(std::vector<int>{3, 0, 1, 2, 3, 0, 2, 1}));
    }
    for (std::size_t i = 0; i < points.size(); ++i) (*shape.points)[i] = (points[i] - mean) * scale;
    return *shape.convex;
  }

 private:
  struct Shape {
    std::shared_ptr<std::vector<Vec3>> points;
    std::unique_ptr<fcl::Convexd> convex;
  };

  std::vector<Shape> shapes_;
};

FclOverlap::FclOverlap() : a_(std::make_unique<Shapes>()), b_(std::make_unique<Shapes>()) {}
FclOverlap::~FclOverlap() = default;

bool FclOverlap::operator()(std::span<const Vec3> a, std::span<const Vec3> b) {
  Vec3 low = a[0], high = low;
  const auto mean_of = [&](std::span<const Vec3> points) {
    Vec3 sum = Vec3::Zero();
    for (const Vec3& p : points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
      sum += p / static_cast<double>(points.size());
    }
    return sum;
  };
  const Vec3 mean_a = mean_of(a), mean_b = mean_of(b);
  const double extent = (high - low).maxCoeff();
  // all points are at one place, so that an overlap would be less deep than FCL is used for
  if (!(extent > 1e-150)) return false;
  const double scale = 1 / extent;
  const Vec3 half = (mean_b - mean_a) * (scale / 2);
  const fcl::CollisionRequestd request;  // a boolean query with libccd
  fcl::CollisionResultd result;
  fcl::collide(&a_->set_points(a, mean_a, scale), fcl::Transform3d(fcl::Translation3d(-half)),
               &b_->set_points(b, mean_b, scale), fcl::Transform3d(fcl::Translation3d(half)), request, result);
  return result.isCollision();
}

}  // namespace volccd::detail
