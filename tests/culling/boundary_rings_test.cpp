// Rings whose faces are nearly upright: rounding must not make a face that folds pass.
#include <volccd/culling/detail/boundary_rings.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/oracle/cases/shapes.hpp>

namespace volccd::detail {
namespace {

constexpr Index kSides = 6;

/// Triangles around vertex 0 at the origin, in a step in which they move together.
class Fan {
 public:
  Fan(int control_points, Random& random)
      : control_points_(control_points),
        drift_(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1)) {
    shape_.positions.push_back(Vec3::Zero());
    for (Index i = 0; i < kSides; ++i) {
      const double angle = 2 * 3.14159265358979 * (i + random.uniform(-0.2, 0.2)) / kSides,
                   length = random.uniform(0.5, 1);
      shape_.positions.push_back(Vec3(length * std::cos(angle), length * std::sin(angle), random.uniform(-0.2, 0.2)));
      const Index next = (i + 1) % kSides + 1;
      shape_.elements.push_back({ElementType::triangle, {0, i + 1, next}, {}, 0, i});
      faces_.push_back({{0, i + 1, next}});
    }
    topology_.emplace(shape_.mesh());
    rings_.set_faces(topology_->mesh(), faces_);
  }

  const Vec3& side() const { return shape_.positions[1]; }

  /// Whether the ring folds if vertex 1 is there.
  bool folds(const Vec3& side) {
    shape_.positions[1] = side;
    std::vector<Vec3> half = shape_.positions, end = shape_.positions;
    for (Vec3& p : half) p += drift_ / 2;
    for (Vec3& p : end) p += drift_;
    const Motion motion =
        control_points_ == 2 ? Motion::linear(shape_.positions, end) : Motion::quadratic(shape_.positions, half, end);
    SerialExecutor executor;
    rings_.find_folds({*topology_, motion, filter_}, executor, folds_);
    return folds_[0] != 0;
  }

  /// The least dot product of `up` and a normal, over the product of the magnitudes, in extended precision.
  long double least_cosine() const {
    using Long3 = Eigen::Matrix<long double, 3, 1>;
    const Long3 up = rings_.up(0).cast<long double>();
    long double least = 1;
    for (const RingFace& face : faces_) {
      const Long3 a = shape_.positions[face.triangle[1]].cast<long double>();
      const Long3 b = shape_.positions[face.triangle[2]].cast<long double>();
      const Long3 normal = a.cross(b);
      least = std::min(least, up.dot(normal) / (up.norm() * normal.norm()));
    }
    return least;
  }

 private:
  int control_points_;
  Vec3 drift_;
  Shape shape_;
  std::vector<RingFace> faces_;
  std::optional<Topology> topology_;
  ObjectFilter filter_;
  BoundaryRings rings_;
  std::vector<std::uint8_t> folds_;
};

// A vertex of the ring is moved until the ring folds, and then by tiny amounts to and fro.
TEST(BoundaryRings, NoFaceThatIsNearlyUprightPassesByRounding) {
  Random random(3);
  int passed = 0, folded = 0;
  for (int round = 0; round < 400; ++round) {
    Fan fan(2 + round % 2, random);
    const Vec3 from = fan.side();
    const Vec3 way(-2.5 * from.x() + random.uniform(-0.3, 0.3), -2.5 * from.y(), random.uniform(-0.5, 0.5));
    if (fan.folds(from) || !fan.folds(from + way)) continue;
    double flat = 0, upright = 1;
    for (int i = 0; i < 40; ++i) {
      const double middle = (flat + upright) / 2;
      (fan.folds(from + middle * way) ? upright : flat) = middle;
    }
    for (int i = -20; i <= 20; ++i)
      if (fan.folds(from + (flat + i * 0x1p-27) * way)) {
        ++folded;
      } else {
        ++passed;
        EXPECT_GT(fan.least_cosine(), 0) << "round " << round;
      }
  }
  EXPECT_GT(passed, 2000);
  EXPECT_GT(folded, 2000);
}

}  // namespace
}  // namespace volccd::detail
