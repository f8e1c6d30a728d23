#include <volccd/oracle/overlap_oracle.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include <volccd/core/error.hpp>
#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/oracle/detail/convex_pieces.hpp>
#include <volccd/oracle/detail/separation.hpp>

#include "oracle/naive_contacts.hpp"

namespace volccd {
namespace {

/// Two shapes, of which the second moves by `by` during the step. Owns all objects to which the Step refers.
struct Scene {
  Scene(const Shape& first, const Shape& second, const Vec3& by, double jitter, std::uint64_t seed,
        EdgeSet edges = EdgeSet::triangulated)
      : shape(Shape().append(first, 1).append(second, 2)), topology(shape.mesh(), edges) {
    const std::vector<Vec3> x0 = jittered(shape.positions, jitter, seed);
    std::vector<Vec3> x1 = jittered(shape.positions, jitter, seed + 1000);
    for (std::size_t v = first.positions.size(); v < x1.size(); ++v) x1[v] += by;
    motion = Motion::linear(x0, x1);
  }

  Step step() const { return {topology, motion, filter}; }
  OverlapReport check(std::span<const Contact> contacts, std::span<const double> times) {
    return check_against_fcl(step(), contacts, times, executor);
  }

  Shape shape;
  Topology topology;
  Motion motion;
  ObjectFilter filter;
  SerialExecutor executor;
};

Shape moved(Shape shape, const Vec3& by) { return shape.translate(by); }

std::uint64_t sum_of_verdicts(const OverlapReport& r) {
  return r.confirmed + r.initial + r.shallow + r.filtered + r.violations.size();
}

TEST(OverlappingElements, CellsOfTwoBlocksAtKnownPlaces) {
  // Cells are axis-aligned unit boxes: at time t the second block has moved by t * (-2, -0.3, -0.2).
  const Shape still = block(ElementType::hexahedron, 3, 2, 2);
  const Vec3 start(3.1, 0.37, 0.41), by(-2, -0.3, -0.2);
  Scene scene(still, moved(still, start), by, 0, 1);
  for (const double t : {0.0, 0.2, 0.5, 1.0}) {
    std::vector<ElementPair> expected;
    const auto low = [&](Index o) { return scene.motion.position(scene.topology.mesh().vertices(o)[0], t); };
    for (Index a = 0; a < 12; ++a)
      for (Index b = 12; b < 24; ++b)
        if (((low(a) - low(b)).cwiseAbs().array() < 1).all()) expected.push_back({a, b});
    const std::vector<Overlap> found = overlapping_elements(scene.step(), t, scene.executor);
    ASSERT_EQ(found.size(), expected.size()) << "t = " << t;
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(found[i].pair, expected[i]);
      EXPECT_GT(found[i].depth, 0);
      const double depth = 1 - (low(found[i].pair.a) - low(found[i].pair.b)).cwiseAbs().maxCoeff();
      EXPECT_LE(found[i].depth, depth + 1e-12) << "a lower estimate";
    }
    EXPECT_EQ(found.empty(), t == 0.0);
  }
}

TEST(OverlappingElements, AdjacentElementsAreNotAskedAbout) {
  const Shape shape = block(ElementType::tetrahedron, 2, 2, 2);
  const Topology topology(shape.mesh());
  const Motion motion = Motion::linear(shape.positions, shape.positions);
  const ObjectFilter filter;
  SerialExecutor executor;
  // Elements of one conforming mesh that share no vertex are strictly apart.
  EXPECT_TRUE(overlapping_elements({topology, motion, filter}, 0.5, executor).empty());
}

TEST(OverlappingElements, ContainedElementIsAnOverlap) {
  Shape small = block(ElementType::tetrahedron, 1, 1, 1);
  for (Vec3& p : small.positions) p = 0.1 * p + Vec3::Constant(0.5);
  Scene scene(block(ElementType::hexahedron, 1, 1, 1), small, Vec3::Zero(), 0, 1);
  EXPECT_EQ(overlapping_elements(scene.step(), 0, scene.executor).size(), 6u);
}

TEST(OverlappingElements, BodyIsNotItsConvexHull) {
  // The top of the hexahedron is bent inwards along the diagonal that splits it. A small tetrahedron is in the cavity,
  // inside the convex hull of the eight vertices.
  Shape hollow = block(ElementType::hexahedron, 1, 1, 1);
  hollow.positions[4].z() = 0.4;
  hollow.positions[7].z() = 0.4;
  Shape small = block(ElementType::tetrahedron, 1, 1, 1);
  small.elements.resize(1);
  for (Vec3& p : small.positions) p = 0.05 * p + Vec3(0.45, 0.45, 0.75);
  Scene scene(hollow, small, Vec3::Zero(), 0, 1);
  EXPECT_TRUE(overlapping_elements(scene.step(), 0, scene.executor).empty());
  Scene lower(hollow, moved(small, Vec3(0, 0, -0.5)), Vec3::Zero(), 0, 1);
  EXPECT_EQ(overlapping_elements(lower.step(), 0, lower.executor).size(), 1u);
}

TEST(OverlappingElements, DistortedBodyIsNotTheTetrahedraAroundItsCentroid) {
  // Places that are covered by tetrahedra of both orientations, and have winding number 0 with respect to the surface.
  int found = 0;
  Shape small = block(ElementType::tetrahedron, 1, 1, 1);
  small.elements.resize(1);
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Shape cell = block(ElementType::hexahedron, 1, 1, 1);
    cell.positions = jittered(cell.positions, 0.8, seed);
    std::vector<detail::ConvexPiece> pieces;
    detail::append_pieces(cell.mesh(), cell.positions, 0, detail::Cover::around, pieces);
    Vec3 place = Vec3::Zero();
    for (const Vec3& p : pieces[seed % pieces.size()].points) place += p / 4;
    int winding = 0, cover = 0;
    double clear = INFINITY;
    for (const detail::ConvexPiece& piece : pieces) {
      Eigen::Matrix3d m;
      for (int i = 0; i < 3; ++i) m.col(i) = piece.points[static_cast<std::size_t>(i)] - piece.points[3];
      const Vec3 w = m.inverse() * (place - piece.points[3]);
      if (w.minCoeff() > 0 && w.sum() < 1) {
        ++cover;
        winding += m.determinant() > 0 ? 1 : -1;
      }
      const detail::ConvexPiece surface{piece.points, 3}, point{{place, place, place, place}, 4};
      clear = std::min(clear, detail::signed_gap(surface, point));
    }
    if (winding != 0 || cover == 0 || clear < 0.02) continue;
    ++found;
    Shape tiny = small;
    for (Vec3& p : tiny.positions) p = place + 0.005 * p;
    Scene scene(cell, tiny, Vec3::Zero(), 0, 1);
    EXPECT_TRUE(overlapping_elements(scene.step(), 0, scene.executor).empty()) << "seed " << seed;
  }
  EXPECT_GT(found, 2);
}

TEST(OverlappingElements, SameForAnyNumberOfThreads) {
  Scene scene(mixed_block(2, 2), moved(mixed_block(2, 2), Vec3(0.3, 0.2, 2.2)), Vec3(0, 0, -1), 0.1, 3);
  const auto threads = make_thread_executor(4);
  const auto one = overlapping_elements(scene.step(), 0.9, scene.executor);
  const auto four = overlapping_elements(scene.step(), 0.9, *threads);
  ASSERT_EQ(one.size(), four.size());
  EXPECT_GT(one.size(), 10u);
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].pair, four[i].pair);
    EXPECT_EQ(one[i].depth, four[i].depth);
  }
}

TEST(CheckInitialOverlaps, TellsMissingAndExtra) {
  Scene scene(block(ElementType::tetrahedron, 2, 2, 1),
              moved(block(ElementType::hexahedron, 2, 2, 1), Vec3(0.3, 0.4, 0.5)), Vec3(0, 0, 0), 0.05, 3);
  std::vector<ElementPair> listed;
  for (const Overlap& overlap : overlapping_elements(scene.step(), 0, scene.executor)) listed.push_back(overlap.pair);
  ASSERT_GT(listed.size(), 10u);
  const auto check = [&](const std::vector<ElementPair>& list) {
    return check_initial_overlaps(scene.step(), list, scene.executor);
  };
  EXPECT_TRUE(check(listed).clean());
  EXPECT_EQ(check(listed).hits, listed.size());
  std::vector<ElementPair> shorter = listed;
  shorter.erase(shorter.begin() + 4);
  ASSERT_EQ(check(shorter).missing.size(), 1u);
  EXPECT_EQ(check(shorter).missing[0].pair, listed[4]);
  EXPECT_TRUE(check(shorter).extra.empty());
  // The element itself, an adjacent one, reversed pairs, an index beyond the last one, and elements that are far apart.
  const Index slots = scene.topology.mesh().element_slots();
  for (const ElementPair wrong : {ElementPair{0, 0}, {0, 1}, {listed[0].b, listed[0].a}, {0, slots}, {0, slots - 1}}) {
    std::vector<ElementPair> longer = listed;
    longer.insert(std::lower_bound(longer.begin(), longer.end(), wrong), wrong);
    EXPECT_EQ(check(longer).extra, std::vector{wrong}) << wrong.a << " " << wrong.b;
  }
  scene.filter = ObjectFilter(PairScope::intra);
  EXPECT_EQ(check(listed).extra.size(), listed.size());
  EXPECT_EQ(check(listed).hits, 0u);
}

TEST(CheckAgainstFcl, CleanOnAllContactsOfMixedMeshes) {
  std::uint64_t confirmed = 0, surface_only = 0;
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const Shape shape = permuted(mixed_block(1, 1), seed);
    Scene scene(shape, moved(shape, Vec3(0.3, 0.2, 1.5)), Vec3(0.2, 0, -1), seed < 3 ? 0.1 : 0.3, seed);
    const std::vector<Contact> contacts = test::naive_contacts(scene.step());
    const OverlapReport report = scene.check(contacts, std::vector{0.0, 0.3, 0.55, 0.8, 1.0});
    EXPECT_TRUE(report.clean()) << "seed " << seed;
    EXPECT_EQ(report.hits, sum_of_verdicts(report));
    EXPECT_EQ(report.times, 5u);
    confirmed += report.confirmed;
    surface_only += report.surface_only;
  }
  EXPECT_GT(confirmed, 200u);
  EXPECT_GT(surface_only, 0u) << "some elements were distorted badly";
}

/// Whether the contact is between a feature of element a and one of b, found from vertices only.
bool between(const Mesh& mesh, const Contact& c, Index a, Index b) {
  const auto all_in = [&](std::size_t begin, std::size_t end, Index o) {
    const auto vertices = mesh.vertices(o);
    for (std::size_t i = begin; i < end; ++i)
      if (std::find(vertices.begin(), vertices.end(), c.vertices[i]) == vertices.end()) return false;
    return true;
  };
  const std::size_t split = c.kind == FeatureKind::vf ? 1 : 2;
  return (all_in(0, split, a) && all_in(split, 4, b)) || (all_in(0, split, b) && all_in(split, 4, a));
}

TEST(CheckAgainstFcl, RemovedContactIsAViolation) {
  int removals = 0;
  for (std::uint64_t seed = 0; seed < 2; ++seed) {
    const Shape shape = permuted(mixed_block(1, 1), seed);
    Scene scene(shape, moved(shape, Vec3(0.3, 0.2, 1.5)), Vec3(0.2, 0, -1), 0.15, seed);
    const std::vector<Contact> contacts = test::naive_contacts(scene.step());
    const double t = 0.7;
    const auto start = overlapping_elements(scene.step(), 0, scene.executor);
    for (const Overlap& hit : overlapping_elements(scene.step(), t, scene.executor)) {
      if (hit.depth < 1e-5 || std::any_of(start.begin(), start.end(), [&](auto& o) { return o.pair == hit.pair; }))
        continue;
      std::vector<Contact> rest;
      for (const Contact& c : contacts)
        if (c.toi > t || !between(scene.topology.mesh(), c, hit.pair.a, hit.pair.b)) rest.push_back(c);
      ASSERT_LT(rest.size(), contacts.size());
      const OverlapReport report = scene.check(rest, std::vector{t});
      const auto v = std::find_if(report.violations.begin(), report.violations.end(),
                                  [&](const OverlapViolation& x) { return x.pair == hit.pair; });
      ASSERT_NE(v, report.violations.end());
      EXPECT_EQ(v->time, t);
      EXPECT_EQ(v->depth, hit.depth);
      EXPECT_GT(v->first_contact, t);
      ++removals;
    }
  }
  EXPECT_GT(removals, 25);
}

TEST(CheckAgainstFcl, ContactCountsWhicheverElementItsFirstFeatureIsOf) {
  // Element 0 has the vertices 8 .. 15, element 1 the vertices 0 .. 7: cells in VTK order with slots in lattice order.
  Shape shape =
      Shape().append(block(ElementType::hexahedron, 1, 1, 1), 1).append(block(ElementType::hexahedron, 1, 1, 1), 2);
  std::swap(shape.elements[0], shape.elements[1]);
  const Topology topology(shape.mesh());
  std::vector<Vec3> x0 = shape.positions, x1 = shape.positions;
  for (std::size_t v = 8; v < 16; ++v) {
    x0[v] += Vec3(1.5, 0.3, 0.2);
    x1[v] += Vec3(0.5, 0.3, 0.2);
  }
  const Motion motion = Motion::linear(x0, x1);
  const ObjectFilter filter;
  SerialExecutor executor;
  const auto confirms = [&](FeatureKind kind, const std::array<Index, 4>& vertices) {
    const std::vector<Contact> contacts = {{kind, vertices, 0.5, Vec3::Zero(), {}, Vec3::Zero()}};
    return check_against_fcl({topology, motion, filter}, contacts, std::vector{1.0}, executor).confirmed == 1;
  };
  EXPECT_TRUE(confirms(FeatureKind::ee, {0, 1, 8, 9}));
  EXPECT_TRUE(confirms(FeatureKind::ee, {0, 3, 8, 11})) << "diagonals of the bottom";
  EXPECT_TRUE(confirms(FeatureKind::vf, {0, 8, 9, 11}));
  EXPECT_TRUE(confirms(FeatureKind::vf, {8, 0, 1, 3}));
  EXPECT_FALSE(confirms(FeatureKind::ee, {1, 2, 8, 9})) << "not the diagonal of this face";
  EXPECT_FALSE(confirms(FeatureKind::ee, {0, 7, 8, 9})) << "no edge: a space diagonal";
  EXPECT_FALSE(confirms(FeatureKind::vf, {0, 8, 9, 10})) << "the other split of the face";
  EXPECT_FALSE(confirms(FeatureKind::vf, {0, 1, 3, 5})) << "within one element";
  EXPECT_FALSE(confirms(FeatureKind::ee, {0, 1, 2, 3})) << "within one element";
}

TEST(CheckAgainstFcl, LateContactsAreViolations) {
  Scene scene(block(ElementType::tetrahedron, 2, 2, 1),
              moved(block(ElementType::tetrahedron, 2, 2, 1), Vec3(0.1, 0.2, 1.2)), Vec3(0, 0, -0.5), 0.02, 5);
  std::vector<Contact> contacts = test::naive_contacts(scene.step());
  EXPECT_TRUE(scene.check(contacts, std::vector{0.6}).clean());
  for (Contact& c : contacts) c.toi = std::max(c.toi, 0.6 + 1e-5);
  const OverlapReport late = scene.check(contacts, std::vector{0.6});
  EXPECT_FALSE(late.clean());
  EXPECT_EQ(late.confirmed, 0u);
  for (const OverlapViolation& v : late.violations) EXPECT_EQ(v.first_contact, 0.6 + 1e-5);
  EXPECT_TRUE(
      check_against_fcl(scene.step(), contacts, std::vector{0.6}, scene.executor, {.time_tolerance = 1e-4}).clean());
}

TEST(CheckAgainstFcl, ShallowHitsAreOnlyCounted) {
  // The cells overlap by 1e-4 at the end.
  Scene scene(block(ElementType::hexahedron, 1, 1, 1),
              moved(block(ElementType::hexahedron, 1, 1, 1), Vec3(1.5, 0.3, 0.2)), Vec3(-0.5001, 0, 0), 0, 1);
  EXPECT_EQ(scene.check({}, std::vector{1.0}).violations.size(), 1u);
  const OverlapReport report =
      check_against_fcl(scene.step(), {}, std::vector{1.0}, scene.executor, {.min_depth = 1e-3});
  EXPECT_EQ(report.shallow, 1u);
  EXPECT_TRUE(report.clean());
}

TEST(CheckAgainstFcl, NothingIsOwedToInitialOverlapsOrTouches) {
  for (const double overlap : {0.0, 1e-12, 0.4}) {
    Scene scene(block(ElementType::hexahedron, 1, 1, 1),
                moved(block(ElementType::hexahedron, 1, 1, 1), Vec3(1 - overlap, 0.3, 0.2)), Vec3(-0.2, 0, 0), 0, 1);
    const OverlapReport report = scene.check({}, std::vector{1.0});
    EXPECT_EQ(report.hits, 1u);
    EXPECT_EQ(report.initial, 1u) << overlap;
  }
}

TEST(CheckAgainstFcl, FilterSaysWhatIsAskedFor) {
  Scene scene(block(ElementType::hexahedron, 1, 1, 1),
              moved(block(ElementType::hexahedron, 1, 1, 1), Vec3(1.5, 0.3, 0.2)), Vec3(-1, 0, 0), 0, 1);
  scene.filter = ObjectFilter(PairScope::intra);
  const OverlapReport report = scene.check({}, std::vector{1.0});
  EXPECT_EQ(report.filtered, 1u);
  EXPECT_TRUE(report.clean());
}

TEST(CheckAgainstFcl, QuadraticMotion) {
  // Free fall: the second cell reverses its motion in the middle of the step, when it overlaps the first.
  const Shape cell = block(ElementType::hexahedron, 1, 1, 1);
  Scene scene(cell, moved(cell, Vec3(0.3, 0.2, 1.2)), Vec3::Zero(), 0, 1);
  std::vector<Vec3> middle = scene.shape.positions;
  for (std::size_t v = 8; v < 16; ++v) middle[v].z() -= 1;
  scene.motion = Motion::quadratic(scene.shape.positions, middle, scene.shape.positions);
  const OverlapReport report = scene.check({}, std::vector{0.0, 0.5, 1.0});
  ASSERT_EQ(report.violations.size(), 1u);
  EXPECT_EQ(report.violations[0].time, 0.5);
  EXPECT_NEAR(report.violations[0].depth, 0.3, 0.05);
}

TEST(CheckAgainstFcl, RefusesWhatItCannotJudge) {
  const Shape cell = block(ElementType::hexahedron, 1, 1, 1);
  Scene scene(cell, moved(cell, Vec3(2, 0, 0)), Vec3::Zero(), 0, 1);
  EXPECT_THROW(scene.check({}, std::vector{1.5}), ConfigError);
  EXPECT_THROW(scene.check({}, std::vector{-0.1}), ConfigError);
  EXPECT_THROW(scene.check({}, std::vector<double>{NAN}), ConfigError);
  EXPECT_THROW(overlapping_elements(scene.step(), NAN, scene.executor), ConfigError);
  Step early = scene.step();
  early.t_max = 0.5;
  EXPECT_THROW(check_against_fcl(early, {}, std::vector{0.6}, scene.executor), ConfigError);
  Scene counts(cell, cell, Vec3::Zero(), 0, 1, EdgeSet::polytope);
  EXPECT_THROW(counts.check({}, std::vector{0.5}), ConfigError);
}

}  // namespace
}  // namespace volccd
