// `boundary-flood` loses no contact, whatever the deformation; compared with the same pipeline without it.
#include <volccd/broadphase/kdop_bvh.hpp>
#include <volccd/culling/flood/boundary_flood.hpp>

#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "pipelines/flood_contest.hpp"
#include "pipelines/flood_scenes.hpp"
#include "support/cut.hpp"
#include "support/trials.hpp"

namespace volccd {
namespace {

using test::Contest;
using test::FloodScene;
using test::FloodScenes;
using test::kNoFilter;
using test::registry;
using test::spec_of;
using test::trials;

/// Parts of a mesh: of its elements at random, or those on one side of a plane. The flood classifies stars that are
/// cut with all their elements.
std::size_t compare_parts(const FloodScene& scene, Random& random, const std::string& what) {
  Contest flood;
  std::size_t contacts = 0;
  for (int k = 0; k < 2; ++k) {
    const double share = random.uniform(0.3, 0.9);
    const Vec3 side(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    const test::Cut part(scene.topology, [&](Index o) {
      const Vec3 x = scene.linear.point(scene.topology.mesh().vertices(o)[0], 0) - Vec3(1, 1, 1);
      return k == 0 ? random.uniform() < share : x.dot(side) > 0;
    });
    if (part.topology.mesh().element_count() == 0) continue;
    Step step{part.topology, scene.linear, kNoFilter};
    step.piece = part.piece();
    contacts += flood.compare(step, what + ", a part");
    step.separation = random.uniform(0, 0.1);
    flood.compare(step, what + ", a part, separation " + std::to_string(step.separation));
  }
  return contacts;
}

std::size_t compare_scenes(std::uint64_t first_seed, int count) {
  std::size_t contacts = 0;
  for (int i = 0; i < count && !testing::Test::HasFailure(); ++i) {
    const std::uint64_t seed = first_seed + static_cast<std::uint64_t>(i);
    FloodScene scene = FloodScenes(seed).make();
    Contest contest;
    const std::string what = "seed " + std::to_string(seed) + ": " + scene.what;
    contacts += contest.compare({scene.topology, scene.linear, kNoFilter}, what);
    const ObjectFilter inter(PairScope::inter);
    constexpr std::array separations = {0.003, 0.03, 0.1, 0.3};
    const double separation = separations[Random(seed).below(separations.size())];
    const std::string apart = what + ", separation " + std::to_string(separation);
    if (i % 3 == 0) contest.compare({scene.topology, scene.linear, kNoFilter, separation}, apart);
    if (i % 4 == 0) contest.compare({scene.topology, scene.linear, kNoFilter, 0, 0.4}, what + ", t_max 0.4");
    if (i % 4 == 1) contest.compare({scene.topology, scene.quadratic, kNoFilter}, what + ", quadratic");
    if (i % 9 == 1) contest.compare({scene.topology, scene.quadratic, kNoFilter, separation}, apart + ", quadratic");
    if (i % 4 == 2) contest.compare({scene.topology, scene.linear, inter}, what + ", pairs of different objects");
    if (i % 4 == 3)
      contest.compare({scene.topology, scene.linear, kNoFilter}, what + ", first", {.query = Query::first});
    TopologyEdit edit;
    Random random(seed);
    for (Index o = 0; o < scene.topology.mesh().element_slots(); ++o)
      if (random.below(5) == 0) edit.removed.push_back(o);
    scene.topology.apply(edit);
    contacts += contest.compare({scene.topology, scene.linear, kNoFilter}, what + ", edited");
    contacts += compare_parts(scene, random, what);
  }
  return contacts;
}

/// Blocks with interior elements, one deep inside the other at the start, in a small motion. Contacts are then far from
/// where the boundaries cross.
TEST(BoundaryFlood, FindsContactsDeepInAPenetration) {
  for (const ElementType type : {ElementType::tetrahedron, ElementType::hexahedron, ElementType::wedge})
    for (const Vec3& at : {Vec3(2.53, 1.31, 1.17), Vec3(1.27, 1.41, 1.63)}) {
      Shape both = block(type, 5, 5, 5), other = block(type, 2, 2, at.x() > 2 ? 6 : 2);
      // Rotated, so that the first vertex of the protruding part is outside.
      for (Vec3& p : other.positions)
        p = Vec3(0.9 * p.x(), 1.8 - 0.9 * p.y(), (at.x() > 2 ? 5.4 : 1.8) - 0.9 * p.z()) + at;
      both.append(other, 2);
      const Topology topology(both.mesh());
      std::vector<Vec3> end = both.positions;
      for (std::size_t v = end.size() - other.positions.size(); v < end.size(); ++v) end[v] += Vec3(0.21, 0.33, 0.12);
      EXPECT_GT(Contest().compare({topology, Motion::linear(both.positions, end), kNoFilter}, to_string(type)), 20u);
    }
}

/// An object inside another one, of two parts that have one vertex in common. At the start, the flood begins at a
/// vertex of the first part, and reaches the second one over the common vertex alone.
TEST(BoundaryFlood, FindsContactsOfAnObjectInsideThatIsJoinedAtAVertex) {
  for (const double separation : {0.0, 0.02}) {
    Shape all = block(ElementType::tetrahedron, 5, 5, 5);
    const auto outside = static_cast<Index>(all.positions.size());
    Shape inside = block(ElementType::tetrahedron, 2, 2, 2);
    for (Vec3& p : inside.positions) p = 0.6 * p + Vec3(1.1, 1.2, 1.3);
    const Vec3 joint = Vec3(1.2, 1.2, 1.2) + Vec3(1.1, 1.2, 1.3);
    all.append(inside, 2);
    for (Vec3& p : inside.positions) p += Vec3(1.2, 1.2, 1.2);
    all.append(inside, 2);
    Index first = kNone;
    for (Index v = outside; v < all.positions.size(); ++v) {
      if ((all.positions[v] - joint).norm() > 1e-9) continue;
      if (first == kNone) first = v;
      for (ElementSpec& e : all.elements) e.renumber([&](Index w) { return w == v ? first : w; });
    }
    std::vector<Vec3> end = all.positions;
    for (std::size_t v = outside; v < end.size(); ++v) end[v] += Vec3(0.11, 0.07, 0.05);
    const Topology topology(all.mesh());
    const Motion motion = Motion::linear(all.positions, end);
    EXPECT_GT(Contest().compare({topology, motion, kNoFilter, separation}, "separation " + std::to_string(separation)),
              50u);
  }
}

/// A vertex at the origin whose tetrahedra surround the z axis once or twice. Inside the volume, the ring is between a
/// pole below and a pole above. On the boundary, there is a pole below only, so that faces with upward normals form a
/// ring that surrounds the axis twice, with its first turn above the second.
FloodScene around(int turns, bool inside, std::uint64_t seed) {
  constexpr int kSides = 14;
  Random random(seed);
  Shape shape;
  shape.positions = {Vec3::Zero(), Vec3(0, 0, inside ? -1 : -0.05), Vec3(0, 0, 1)};
  for (int i = 0; i < kSides; ++i) {
    const double angle = 2 * turns * std::numbers::pi * i / kSides, radius = random.uniform(0.8, 1.2);
    const double height = inside ? 0 : i < kSides / 2 ? 0.3 : -0.5;
    shape.positions.push_back(radius * Vec3(std::cos(angle), std::sin(angle), height));
  }
  for (Index i = 0; i < kSides; ++i) {
    const Index u = 3 + i, w = 3 + (i + 1) % kSides;
    shape.elements.push_back({ElementType::tetrahedron, {0, w, u, 1}, {}, 0, 2 * i});
    if (inside) shape.elements.push_back({ElementType::tetrahedron, {0, u, w, 2}, {}, 0, 2 * i + 1});
  }
  if (!inside) {  // every vertex needs an element, and the pole above is not used
    shape.positions.erase(shape.positions.begin() + 2);
    for (ElementSpec& e : shape.elements)
      for (Index& v : e.vertices) v -= v > 2 ? 1 : 0;
  }
  const Motion linear =
      Motion::linear(jittered(shape.positions, 0.02, seed), jittered(shape.positions, 0.05, seed + 1));
  return {Topology(shape.mesh()), linear, linear, inside ? "inside" : "on the boundary"};
}

/// Data of a star are discarded if the next step does not continue the last one, even if all volumes keep their signs.
TEST(BoundaryFlood, AStarThatGoesAroundTwiceAfterAJumpIsSuspect) {
  std::size_t contacts = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const FloodScene once = around(1, true, seed), twice = around(2, true, seed);
    Contest contest;
    contest.compare({once.topology, once.linear, kNoFilter}, "once around");
    contacts += contest.compare({once.topology, twice.linear, kNoFilter}, "then twice");
  }
  EXPECT_GT(contacts, 0u);
}

/// Stages that assign fewer features of a pair when it touches late, and stages that cull less or nothing, lose
/// nothing.
TEST(BoundaryFlood, FindsAllContactsWithAnyElementCulling) {
  for (const char* culling : {"csat.mode=features", "csat.mode=both", "csat.axis=centroid", "element-culling=none"}) {
    PipelineSpec spec = spec_of("boundary-flood");
    registry().apply_setting(spec, culling);
    std::size_t contacts = 0;
    for (std::uint64_t seed = 300; seed < 306; ++seed) {
      const FloodScene scene = FloodScenes(seed).make();
      const std::string what = "seed " + std::to_string(seed) + ": " + scene.what + ", " + culling;
      contacts += Contest(spec).compare({scene.topology, scene.linear, kNoFilter}, what);
    }
    EXPECT_GT(contacts, 100u) << culling;
  }
}

TEST(BoundaryFlood, AStarThatGoesAroundTwiceIsSuspect) {
  for (const bool inside : {true, false}) {
    std::size_t contacts = 0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      const FloodScene scene = around(2, inside, seed);
      contacts += Contest().compare({scene.topology, scene.linear, kNoFilter}, scene.what);
    }
    EXPECT_GT(contacts, 0u) << inside;
  }
}

BoundaryFlood::Counters counters_of(const Topology& topology, const Motion& motion) {
  const BoundaryFlood flood({1, 1, 1e9});
  const KdopBvh broad_phase{KdopBvh::Config{}};
  const auto state = flood.make_state_with(broad_phase);
  SerialExecutor serial;
  flood.prepare({topology, motion, kNoFilter}, *state, serial);
  EXPECT_TRUE(flood.takes(*state, false));
  // 140 bytes for a simplex on octopi and octopus2-105k; more for small meshes.
  EXPECT_LT(state->bytes(), 400 * BoundaryFlood::counters(*state).simplices + 100000);
  return BoundaryFlood::counters(*state);
}

/// The broad phase receives one layer of elements, not the volume. A vertex that is pulled through its star adds the
/// elements at the vertices of that star.
TEST(BoundaryFlood, PairsTheBoundaryAndSuspectStars) {
  const Shape shape = block(ElementType::tetrahedron, 7, 7, 7);
  const Topology topology(shape.mesh());
  const std::vector<Vec3> end = jittered(shape.positions, 0.01, 1);
  const BoundaryFlood::Counters calm = counters_of(topology, Motion::linear(shape.positions, end));
  EXPECT_EQ(calm.simplices, topology.mesh().element_count());
  EXPECT_EQ(calm.suspect_vertices, 0u);
  std::size_t boundary = 0;
  for (Index o = 0; o < topology.mesh().element_slots(); ++o) {
    const std::span<const Index> triangles = topology.features().element_triangles(o);
    boundary += std::any_of(triangles.begin(), triangles.end(),
                            [&](Index f) { return topology.features().triangle_elements(f).size() == 1; });
  }
  EXPECT_EQ(calm.paired, boundary);

  Index inner = 0;  // the vertex next to the centre
  for (Index v = 0; v < shape.positions.size(); ++v)
    if ((shape.positions[v] - Vec3(3.5, 3.5, 3.5)).norm() < (shape.positions[inner] - Vec3(3.5, 3.5, 3.5)).norm())
      inner = v;
  std::vector<Vec3> pulled = end;
  pulled[inner] += Vec3(1.6, 0, 0);
  const BoundaryFlood::Counters torn = counters_of(topology, Motion::linear(shape.positions, pulled));
  EXPECT_GT(torn.suspect_vertices, 4u);
  EXPECT_GT(torn.paired, boundary);
  std::size_t near = 0;  // elements at a vertex of the star of the pulled vertex
  const std::span<const Index> star = topology.features().vertex_elements(inner);
  for (Index o = 0; o < topology.mesh().element_slots(); ++o)
    near += std::any_of(star.begin(), star.end(), [&](Index x) { return topology.adjacency().adjacent(x, o); });
  EXPECT_LE(torn.paired, boundary + near);
}

/// A flood that gives up every step with contacts gives the results of the other stages, overlaps included.
TEST(BoundaryFlood, GivesUpWithoutLosingAnything) {
  PipelineSpec spec = spec_of("boundary-flood");
  spec.flood->options["max_pairs"] = "0";
  std::size_t contacts = 0;
  for (std::uint64_t seed = 500; seed < 505; ++seed) {
    const FloodScene scene = FloodScenes(seed).make();
    contacts +=
        Contest(spec).compare({scene.topology, scene.linear, kNoFilter}, scene.what, {.initial_overlaps = true});
  }
  EXPECT_GT(contacts, 0u);
}

/// Two bodies, one deep inside the other, whose contacts are all far from the boundary of the outer one: no pair that
/// was examined before the flood gives up has one.
TEST(BoundaryFlood, GivesUpInABodyInsideAnother) {
  PipelineSpec spec = spec_of("boundary-flood");
  spec.flood->options["max_pairs"] = "0";
  Shape both = block(ElementType::tetrahedron, 5, 5, 5), inside = block(ElementType::tetrahedron, 2, 2, 2);
  const std::size_t outside = both.positions.size();
  for (Vec3& p : inside.positions) p = 0.9 * p + Vec3(1.27, 1.41, 1.63);
  both.append(inside, 2);
  std::vector<Vec3> end = both.positions;
  for (std::size_t v = outside; v < end.size(); ++v) end[v] += Vec3(0.21, 0.33, 0.12);
  const Topology topology(both.mesh());
  const Motion motion = Motion::linear(both.positions, end);
  const Step step{topology, motion, kNoFilter};
  Contest contest(spec);
  EXPECT_GT(contest.compare(step, "inside"), 20u);
  contest.compare(step, "inside, with overlaps", {.initial_overlaps = true});
  EXPECT_GT(contest.initial_overlaps(), 20u);
}

/// Has no blocks, as a broad phase that makes them of the pairs that it has found, if there are none.
class NoBlocks final : public BroadPhase {
 public:
  std::size_t blocks(const Step&, StageState&, Executor&) const override { return 0; }
  void run(const Step&, StageState&, unsigned, std::size_t, Work&) const override {}
};

/// A vertex is on the wrong side of its star from the start.
TEST(BoundaryFlood, ListsOrphansAlsoWhereTheBroadPhaseHasNoPairs) {
  Shape shape = block(ElementType::tetrahedron, 4, 4, 4);
  for (Vec3& p : shape.positions)
    if (p == Vec3(2, 2, 2)) p += Vec3(1.4, 0.3, 0.2);
  const Topology topology(shape.mesh());
  const Motion rest = Motion::linear(shape.positions, shape.positions);
  const Step step{topology, rest, kNoFilter};
  SerialExecutor serial;
  const NoBlocks broad_phase;
  for (const double max_pairs : {1e9, 0.0}) {
    const BoundaryFlood flood({1, 1, 1, max_pairs});
    const auto state = flood.make_state_with(broad_phase);
    flood.prepare(step, *state, serial);
    ASSERT_TRUE(flood.takes(*state, false));
    Work work;
    std::size_t orphan_blocks = 0;
    for (std::size_t number = 0;; ++number) {
      const Round round = flood.next_round(step, *state, number, serial);
      orphan_blocks += round.kind == RoundKind::tests ? round.blocks : 0;
      if (round.blocks == 0) break;
      const std::size_t old_pairs = work.pairs.size();
      for (std::size_t block = 0; block < round.blocks; ++block) flood.run(step, *state, 0, block, work);
      if (max_pairs > 0) flood.record_survivors(*state, 0, std::span(work.pairs).subspan(old_pairs));
    }
    EXPECT_GT(orphan_blocks, 0u) << max_pairs;
    EXPECT_EQ(BoundaryFlood::counters(*state).all_paired, max_pairs == 0);
  }
}

TEST(ThreadsBoundaryFlood, SameContactsAndCountsForAnyNumberOfWorkers) {
  const Pipeline pipeline(registry(), spec_of("boundary-flood"));
  const auto three = make_thread_executor(3);
  SerialExecutor serial;
  for (std::uint64_t seed = 700; seed < 700 + static_cast<std::uint64_t>(trials(12)); ++seed) {
    const FloodScene scene = FloodScenes(seed).make();
    const Step step{scene.topology, scene.linear, kNoFilter};
    StepResult by_one, by_three;
    Workspace first = pipeline.make_workspace(), second = pipeline.make_workspace();
    pipeline.run(step, first, serial, by_one);
    pipeline.run(step, second, *three, by_three);
    EXPECT_TRUE(compare_contacts(by_one.contacts, by_three.contacts).empty()) << scene.what;
    EXPECT_EQ(by_one.statistics.element_pairs, by_three.statistics.element_pairs) << scene.what;
    EXPECT_EQ(by_one.statistics.orphan_tests, by_three.statistics.orphan_tests) << scene.what;
    EXPECT_EQ(by_one.statistics.vf_tests, by_three.statistics.vf_tests) << scene.what;
    EXPECT_EQ(by_one.statistics.ee_tests, by_three.statistics.ee_tests) << scene.what;
  }
}

/// A chain of pairs leads into a region from suspect pairs outside of it.
TEST(BoundaryFlood, DoesNotDependOnTheRegion) {
  const Pipeline pipeline(registry(), spec_of("boundary-flood"));
  SerialExecutor serial;
  FloodScenes scenes(3);
  std::size_t orphans = 0;
  for (int i = 0; i < 20; ++i) {
    const FloodScene scene = scenes.make();
    Step step{scene.topology, scene.linear, kNoFilter};
    const auto statistics = [&] {
      Workspace workspace = pipeline.make_workspace();
      StepResult result;
      pipeline.run(step, workspace, serial, result);
      return result.statistics;
    };
    const Statistics all = statistics();
    step.piece.region.low = Vec3(1e3, 1e3, 1e3);
    const Statistics elsewhere = statistics();
    EXPECT_EQ(elsewhere.element_pairs, all.element_pairs) << scene.what;
    EXPECT_EQ(elsewhere.tests(), all.tests()) << scene.what;
    EXPECT_EQ(elsewhere.orphan_tests, all.orphan_tests) << scene.what;
    orphans += all.orphan_tests;
  }
  EXPECT_GT(orphans, 100u);
}

TEST(BoundaryFlood, AWorkspaceGoesOnWithAMeshOfFewerVertices) {
  Contest contest;
  for (const int n : {3, 2}) {
    const Shape shape = block(ElementType::tetrahedron, n, n, n);
    const Topology topology(shape.mesh());
    for (std::uint64_t step = 0; step < 3; ++step) {  // no step begins where the one before it ended
      const Motion motion =
          Motion::linear(jittered(shape.positions, 0.1, 2 * step), jittered(shape.positions, 0.4, 2 * step + 1));
      contest.compare({topology, motion, kNoFilter},
                      "block of " + std::to_string(n) + ", step " + std::to_string(step));
    }
  }
}

TEST(BoundaryFlood, FindsAllContactsOfMeshesMadeToBreakIt) {
  EXPECT_GT(compare_scenes(1, 16) + compare_scenes(60, 1), 2000u);
}

TEST(LongBoundaryFlood, FindsAllContactsOfMeshesMadeToBreakIt) {
  compare_scenes(17, trials(43));
  compare_scenes(1000, trials(150));
}

}  // namespace
}  // namespace volccd
