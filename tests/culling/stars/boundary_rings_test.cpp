// Rings whose faces are nearly upright: rounding must not make a face that folds pass.
#include <volccd/culling/stars/detail/boundary_rings.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/oracle/cases/shapes.hpp>

#include "culling/quad.hpp"
#include "culling/random_vector.hpp"

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
  long double min_cosine() const {
    using Long3 = Eigen::Matrix<long double, 3, 1>;
    const Long3 up = rings_.up(0).cast<long double>();
    long double min = 1;
    for (const RingFace& face : faces_) {
      const Long3 a = shape_.positions[face.triangle[1]].cast<long double>();
      const Long3 b = shape_.positions[face.triangle[2]].cast<long double>();
      const Long3 normal = a.cross(b);
      min = std::min(min, up.dot(normal) / (up.norm() * normal.norm()));
    }
    return min;
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
        EXPECT_GT(fan.min_cosine(), 0) << "round " << round;
      }
  }
  EXPECT_GT(passed, 2000);
  EXPECT_GT(folded, 2000);
}

/// The first vertex of a triangle, and the edges from it to the others, at each control point.
struct MovingFace {
  std::vector<Vec3> from, a, b;

  int control_points() const { return static_cast<int>(a.size()); }
};

/// A triangle that moves by itself is tested against a direction that horizontal triangles determine.
class TestedFace {
 public:
  TestedFace() {
    for (Index v = 0; v < 5; ++v) shape_.positions.push_back(Vec3::Zero());
    shape_.elements.push_back({ElementType::triangle, {0, 1, 2}, {}, 0, 0});
    shape_.elements.push_back({ElementType::triangle, {0, 3, 4}, {}, 0, 1});
    topology_.emplace(shape_.mesh());
    std::vector<RingFace> faces{{{0, 1, 2}, kNone, 0x1}};
    for (int i = 0; i < 8; ++i) faces.push_back({{0, 3, 4}, kNone, 0});
    rings_.set_faces(topology_->mesh(), faces);
  }

  bool folds(const MovingFace& face, double separation) {
    Motion& motion = motion_.emplace(5, face.control_points());
    for (int c = 0; c < face.control_points(); ++c) {
      const Vec3 from = face.from[static_cast<std::size_t>(c)];
      motion.set(0, c, from);
      motion.set(1, c, from + face.a[static_cast<std::size_t>(c)]);
      motion.set(2, c, from + face.b[static_cast<std::size_t>(c)]);
      motion.set(3, c, from + Vec3(1, 0, 0));
      motion.set(4, c, from + Vec3(0, 1, 0));
    }
    SerialExecutor executor;
    rings_.find_folds({*topology_, motion, filter_, separation}, executor, folds_);
    return folds_[0] != 0;
  }

  /// Whether the normal of the last test has a positive dot product with its direction at some times, also if vertices
  /// are displaced by w/2 or -w/2, |w| <= separation. Any edge can then change by w, which changes the normal by a
  /// cross product with another edge.
  bool stays_upright(double separation) const {
    const Quad3 up(rings_.up(0));
    std::vector<Vec3> points[3];
    for (Index v = 0; v < 3; ++v)
      for (int c = 0; c < motion_->control_points(); ++c) points[v].push_back(motion_->point(v, c));
    for (int i = 0; i <= 32; ++i) {
      const Quad t = Quad(i) / 32;
      const Quad3 from = bezier(points[0], t), a = bezier(points[1], t) - from, b = bezier(points[2], t) - from;
      const Quad product = dot(up, cross(a, b)), d = separation;
      if (!(product > 0)) return false;
      for (const Quad3& edge : {a, b, a - b}) {
        const Quad3 change = cross(edge, up);
        if (!(product * product > d * d * dot(change, change))) return false;
      }
    }
    return true;
  }

 private:
  Shape shape_;
  std::optional<Topology> topology_;
  std::optional<Motion> motion_;
  ObjectFilter filter_;
  BoundaryRings rings_;
  std::vector<std::uint8_t> folds_;
};

/// A triangle that turns around the vertical axis while its edges stretch, each by itself.
MovingFace turning_face(int control_points, Random& random) {
  MovingFace face;
  const double turn = random.uniform(0, 1.3), stretch = random.uniform() < 0.3 ? 0 : random.uniform(0, 6);
  const Vec3 ways[2] = {random_vector(random), random_vector(random)};
  const double angle = random.uniform(0.5, 2.5), lengths[2] = {random.uniform(0.3, 1), random.uniform(0.3, 1)};
  for (int c = 0; c < control_points; ++c) {
    const double t = double(c) / (control_points - 1);
    const auto edge = [&](int i) {
      const double at = turn * t + i * angle;
      return Vec3(lengths[i] * Vec3(std::cos(at), std::sin(at), 0) + t * stretch * ways[i]);
    };
    face.a.push_back(edge(0));
    face.b.push_back(edge(1));
    face.from.push_back(Vec3::Zero());
  }
  return face;
}

/// Calls folds(x) to find the greatest x below 1, apart from 2^-50, for which it is false, beginning with 0, and
/// returns it; -1 if there is none.
template <class Folds>
double last_before_fold(Folds&& folds) {
  if (folds(0.0)) return -1;
  double flat = 0, upright = 1;
  for (int i = 0; i < 50; ++i) {
    const double middle = (flat + upright) / 2;
    (folds(middle) ? upright : flat) = middle;
  }
  return flat;
}

// The greatest separation with which a face is found not to fold is small enough.
TEST(BoundaryRings, NoFaceThatMayFoldWithinTheSeparationPasses) {
  Random random(5);
  TestedFace tested;
  int found = 0;
  for (int round = 0; round < 3000; ++round) {
    const MovingFace face = turning_face(2 + round % 2, random);
    const double separation = last_before_fold([&](double d) { return tested.folds(face, d); });
    if (separation <= 0) continue;
    ++found;
    ASSERT_FALSE(tested.folds(face, separation));
    ASSERT_TRUE(tested.stays_upright(separation)) << "round " << round << ", separation " << separation;
  }
  EXPECT_GT(found, 1000);
}

// The middle control point of one edge is moved until the face is found to fold.
TEST(BoundaryRings, NoFaceThatFoldsByItsAccelerationPasses) {
  Random random(6);
  TestedFace tested;
  int found = 0;
  for (int round = 0; round < 2000; ++round) {
    const MovingFace begin = turning_face(3, random);
    const Vec3 way = 10 * random_vector(random);
    MovingFace face = begin;
    const bool first = round % 2 == 0;
    const double amount = last_before_fold([&](double x) {
      (first ? face.a : face.b)[1] = (first ? begin.a : begin.b)[1] + x * way;
      return tested.folds(face, 0);
    });
    if (amount < 0 || amount > 0.99) continue;
    ++found;
    (first ? face.a : face.b)[1] = (first ? begin.a : begin.b)[1] + amount * way;
    ASSERT_FALSE(tested.folds(face, 0));
    ASSERT_TRUE(tested.stays_upright(0)) << "round " << round << ", amount " << amount;
  }
  EXPECT_GT(found, 300);
}

/// A triangle whose edges have about the same direction at all control points, so that its normals are about as small
/// as their rounding errors if noise = 1, and larger in proportion. One edge is short at the start, where
/// coordinates are exact.
MovingFace sliver(int control_points, bool first_is_short, double noise, Random& random) {
  const double small = 0x1p-26 * std::sqrt(noise);
  const Vec3 line(1, random.uniform(0.5, 1), 0);
  const auto on_line = [&] {
    Vec3 p = random.uniform(1, 2) * line;
    for (int k = 0; k < 2; ++k) p[k] += noise * 0x1p-53 * random.uniform(-2, 2);
    return p;
  };
  MovingFace face;
  for (int c = 0; c < control_points; ++c) {
    face.a.push_back(on_line());
    face.b.push_back(on_line());
    face.from.push_back(c == 0 ? Vec3(0, 0, 0) : Vec3(0x1p-6 * random_vector(random)));  // differences are rounded
  }
  const Vec3 aside(0, small * random.uniform(1, 4), 0);
  if (first_is_short)
    face.a[0] = small * (line - aside);
  else
    face.b[0] = small * (line + aside);
  return face;
}

TEST(BoundaryRings, NoSliverPassesByRounding) {
  Random random(8);
  TestedFace tested;
  int passed = 0, folded = 0;
  for (int round = 0; round < 20000; ++round) {
    const MovingFace face =
        sliver(2 + round % 2, round / 2 % 2 == 0, std::exp2(round % 4 == 0 ? random.uniform(0, 20) : 0), random);
    if (!tested.folds(face, 0)) {
      ++passed;
      ASSERT_TRUE(tested.stays_upright(0)) << "round " << round;
    } else {
      folded += tested.stays_upright(0) ? 0 : 1;
    }
  }
  EXPECT_GT(passed, 50);
  EXPECT_GT(folded, 1000);
}

/// Normals are found by groups of vertices, and here most faces have vertices in several.
TEST(BoundaryRings, AVertexIsTestedWithItsOwnFaces) {
  constexpr Index kWidth = 80, kVertices = kWidth * kWidth;
  Random random(5);
  std::vector<Index> numbers(kVertices);
  std::iota(numbers.begin(), numbers.end(), Index{0});
  random.shuffle(numbers);
  Shape shape;
  shape.positions.resize(kVertices);
  std::vector<Vec3> end(kVertices);
  const auto vertex = [&](Index i, Index j) { return numbers[i * kWidth + j]; };
  for (Index i = 0; i < kWidth; ++i)
    for (Index j = 0; j < kWidth; ++j) {
      shape.positions[vertex(i, j)] = Vec3(i, j, random.uniform(0, 0.3));
      end[vertex(i, j)] = shape.positions[vertex(i, j)] + 0.7 * random_vector(random);
    }
  std::vector<RingFace> faces;
  for (Index i = 0; i + 1 < kWidth; ++i)
    for (Index j = 0; j + 1 < kWidth; ++j) {
      faces.push_back({{vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)}});
      faces.push_back({{vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)}});
    }
  for (const RingFace& face : faces)
    shape.elements.push_back({ElementType::triangle, {face.triangle[0], face.triangle[1], face.triangle[2]}, {}, 0,
                              static_cast<std::int64_t>(shape.elements.size())});
  const Topology topology(shape.mesh());
  const Motion motion = Motion::linear(shape.positions, end);
  const ObjectFilter filter;
  for (const double separation : {0.0, 0.1}) {
    const Step step{topology, motion, filter, separation};
    SerialExecutor executor;
    BoundaryRings all, own;
    std::vector<std::uint8_t> folds, own_folds;
    all.set_faces(topology.mesh(), faces);
    all.find_folds(step, executor, folds);
    int folded = 0;
    for (Index v = 0; v < kVertices; v += 31) {
      std::vector<RingFace> at_vertex;
      for (const RingFace& face : faces)
        if (std::ranges::count(face.triangle, v) > 0) at_vertex.push_back(face);
      own.set_faces(topology.mesh(), at_vertex);
      own.find_folds(step, executor, own_folds);
      EXPECT_EQ(folds[v], own_folds[v]) << "vertex " << v;
      EXPECT_EQ(all.up(v), own.up(v)) << "vertex " << v;
      folded += folds[v];
    }
    EXPECT_GT(folded, 20);
    EXPECT_LT(folded, 180);
  }
}

}  // namespace
}  // namespace volccd::detail
