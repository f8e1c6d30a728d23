// Stars of elements of any type that are clear: features of such a star touch nowhere but in common vertices.
#include <volccd/culling/stars/vertex_stars.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/oracle/cases/shapes.hpp>

#include "culling/exact_contacts.hpp"
#include "culling/stars/ends_in_loop.hpp"
#include "culling/stars/jittered_block.hpp"
#include "culling/stars/some_elements.hpp"
#include "support/cut.hpp"
#include "support/trials.hpp"

namespace volccd::detail {
namespace {

const ObjectFilter kEveryObject;

/// Whether a clear star contains one of the elements `a` and one of `b`.
bool in_a_clear_star(const Mesh& mesh, const VertexStars& stars, std::span<const Index> a, std::span<const Index> b) {
  for (const Index x : a)
    for (const Index y : b)
      for (const Index v : mesh.vertices(x)) {
        const std::span<const Index> of_y = mesh.vertices(y);
        if (!stars.suspect(v) && std::find(of_y.begin(), of_y.end(), v) != of_y.end()) return true;
      }
  return false;
}

/// Positions that a smooth deformation moves, as bending and pressing do, and a little of independent motion.
std::vector<Vec3> deformed(const std::vector<Vec3>& from, Random& random, double amount, double noise) {
  Eigen::Matrix3d a;
  for (int i = 0; i < 9; ++i) a(i / 3, i % 3) = (i % 4 == 0 ? 1 : 0) + amount * random.uniform(-1, 1);
  const double bend = amount * random.uniform(-2, 2);
  std::vector<Vec3> to;
  for (const Vec3& p : from) to.push_back(a * Vec3(p[0], p[1] + bend * p[0] * p[0], p[2] + bend * p[0] * p[1]));
  return noise > 0 ? jittered(to, noise, random.next()) : to;
}

struct Seen {
  std::size_t clear = 0, suspect = 0, touching = 0;
};

/// A few steps of a deforming mesh that loses elements and sometimes jumps.
void expect_clear_stars_do_not_touch(ElementType type, std::uint64_t seed, bool quadratic, double max_separation,
                                     Seen& seen) {
  Random random(seed);
  SerialExecutor serial;
  const auto size = [&] { return 1 + static_cast<int>(random.uniform() * 2); };
  Shape shape = type == ElementType::none ? mixed_block(1, 1) : block(type, size(), size(), 1);
  if (random.uniform() < 0.5) shape = permuted(shape, random.next());
  Topology topology(shape.mesh());
  if (random.uniform() < 0.5) topology.apply({some_elements(topology.mesh(), random, 0.2), {}, {}});
  VertexStars stars;
  std::vector<Vec3> at = deformed(shape.positions, random, 0.5, 0.1);
  for (int step = 0; step < 3; ++step) {
    if (random.uniform() < 0.3) topology.apply({some_elements(topology.mesh(), random, 0.1), {}, {}});
    if (random.uniform() < 0.3) at = deformed(shape.positions, random, 0.8, 0.2);  // a jump
    const std::vector<Vec3> to = deformed(at, random, 0.3, random.uniform() * 0.4),
                            middle = deformed(at, random, 0.2, 0);
    const Motion motion = quadratic ? Motion::quadratic(at, middle, to) : Motion::linear(at, to);
    const Step now{topology, motion, kEveryObject, max_separation * random.uniform()};
    stars.update(now, serial);
    for (Index v = 0; v < motion.vertex_count(); ++v)
      if (!topology.features().vertex_elements(v).empty()) ++(stars.suspect(v) ? seen.suspect : seen.clear);
    visit_touching(now, [&](std::span<const Index> a, std::span<const Index> b) {
      ++seen.touching;
      EXPECT_FALSE(in_a_clear_star(topology.mesh(), stars, a, b)) << to_string(type) << ' ' << seed << ' ' << step;
    });
    at = to;
  }
}

void expect_clear_stars_do_not_touch(double max_separation) {
  for (const ElementType type : {ElementType::tetrahedron, ElementType::hexahedron, ElementType::wedge,
                                 ElementType::pyramid, ElementType::none}) {
    Seen seen;
    for (std::uint64_t seed = 1; seed <= static_cast<std::uint64_t>(test::trials(60)); ++seed)
      expect_clear_stars_do_not_touch(type, seed, seed % 4 == 0, max_separation, seen);
    const auto enough = static_cast<std::size_t>(test::trials(60));
    EXPECT_GT(seen.clear, enough) << to_string(type);
    EXPECT_GT(seen.suspect, enough) << to_string(type);
    EXPECT_GT(seen.touching, enough) << to_string(type);
  }
}

TEST(VertexStars, ClearOnesHaveNoContacts) { expect_clear_stars_do_not_touch(0); }

/// Separations of up to a tenth of an edge.
TEST(VertexStars, ClearOnesStayApart) { expect_clear_stars_do_not_touch(0.1); }

/// In a body at rest, or that turns and is bent a little, nothing is suspect but where shells or polytopes are.
TEST(VertexStars, AllOfASoundBodyAreClear) {
  SerialExecutor serial;
  for (const ElementType type :
       {ElementType::tetrahedron, ElementType::hexahedron, ElementType::wedge, ElementType::pyramid}) {
    const Shape shape = permuted(block(type, 3, 3, 3), 5);
    const Topology topology(shape.mesh());
    std::vector<Vec3> to;
    const Eigen::AngleAxisd turn(0.3, Vec3(1, 2, 3).normalized());
    for (const Vec3& p : shape.positions) to.push_back(turn * Vec3(p[0], p[1] + 0.05 * p[0] * p[0], p[2]));
    VertexStars stars;
    stars.update({topology, Motion::linear(shape.positions, to), kEveryObject}, serial);
    EXPECT_TRUE(stars.suspects().empty()) << to_string(type) << ": " << stars.suspects().size();
    std::vector<Vec3> mirrored = shape.positions;
    for (Vec3& p : mirrored) p[0] = -p[0];
    stars.update({topology, Motion::linear(mirrored, mirrored), kEveryObject}, serial);
    EXPECT_TRUE(stars.suspects().empty()) << to_string(type) << ", mirrored: " << stars.suspects().size();
  }
}

/// A flat block at rest: opposite features of each element are 1/20 apart.
TEST(VertexStars, OfElementsThinnerThanTheSeparationAreSuspect) {
  SerialExecutor serial;
  for (const ElementType type :
       {ElementType::tetrahedron, ElementType::hexahedron, ElementType::wedge, ElementType::pyramid}) {
    Shape shape = block(type, 3, 3, 2);
    for (Vec3& p : shape.positions) p[2] /= 20;
    const Topology topology(shape.mesh());
    const Motion rest = Motion::linear(shape.positions, shape.positions);
    for (const double separation : {0.0, 0.001, 0.051}) {
      VertexStars stars;
      stars.update({topology, rest, kEveryObject, separation}, serial);
      EXPECT_EQ(stars.suspects().size(), separation < 0.05 ? 0 : shape.positions.size())
          << to_string(type) << ", separation " << separation;
    }
  }
}

/// With the elements around it, a part of a mesh has the suspect stars of the mesh.
TEST(VertexStars, OfAPieceAreThoseOfTheMesh) {
  SerialExecutor serial;
  Seen cut;
  for (const ElementType type :
       {ElementType::tetrahedron, ElementType::hexahedron, ElementType::wedge, ElementType::pyramid, ElementType::none})
    for (std::uint64_t seed = 1; seed <= static_cast<std::uint64_t>(test::trials(20)); ++seed) {
      Random random(seed);
      const Shape shape = type == ElementType::none ? mixed_block(2, 2) : block(type, 3, 3, 2);
      Topology topology(permuted(shape, seed).mesh());
      topology.apply({some_elements(topology.mesh(), random, 0.05), {}, {}});
      const test::Cut part(topology, [&](Index) { return random.uniform() < 0.6; });
      std::vector<Vec3> at = deformed(permuted(shape, seed).positions, random, 0.2, 0.02);
      VertexStars of_mesh, of_part;
      for (int i = 0; i < 4; ++i) {
        if (i == 2) at = deformed(permuted(shape, seed).positions, random, 0.5, 0.1);  // a jump
        const std::vector<Vec3> to = deformed(at, random, 0.1, random.uniform() * 0.1);
        const Motion motion = Motion::linear(at, to);
        const double separation = i == 3 ? 0.05 * random.uniform() : 0;
        of_mesh.update({topology, motion, kEveryObject, separation}, serial);
        Step step{part.topology, motion, kEveryObject, separation};
        if (i == 1) {  // as a mesh of its own, whose cut has rings
          VertexStars fresh;
          fresh.update(step, serial);
          of_part.update(step, serial);
          EXPECT_EQ(of_part.suspects(), fresh.suspects()) << to_string(type) << ' ' << seed;
        }
        step.piece = part.piece();
        of_part.update(step, serial);
        std::vector<Index> expected;
        for (const Index v : of_mesh.suspects())
          if (!part.topology.features().vertex_elements(v).empty()) expected.push_back(v);
        EXPECT_EQ(of_part.suspects(), expected) << to_string(type) << ' ' << seed << ' ' << i;
        for (Index v = 0; v < motion.vertex_count(); ++v)
          if (part.complete[v] == 0 && !part.topology.features().vertex_elements(v).empty())
            ++(of_part.suspect(v) ? cut.suspect : cut.clear);
        at = to;
      }
    }
  EXPECT_GT(cut.clear, 100u);
  EXPECT_GT(cut.suspect, 100u);
}

/// The middle of a quadratic motion is so far away that differences overflow: nothing is proven, for any vertex.
TEST(VertexStars, OfOverflowingMotionsAreSuspect) {
  SerialExecutor serial;
  for (const ElementType type :
       {ElementType::tetrahedron, ElementType::hexahedron, ElementType::wedge, ElementType::pyramid}) {
    const Shape shape = block(type, 1, 1, 1);
    const Topology topology(shape.mesh());
    for (std::size_t far = 1; far < shape.positions.size(); ++far) {
      std::vector<Vec3> middle = shape.positions;
      for (std::size_t v = 0; v < middle.size(); ++v) middle[v][0] = v == far ? 1.7e308 : -1e308;
      const Motion motion = Motion::quadratic(shape.positions, middle, shape.positions);
      VertexStars stars;
      stars.update({topology, motion, kEveryObject}, serial);
      EXPECT_TRUE(stars.suspect(static_cast<Index>(far))) << to_string(type) << ' ' << far;
    }
  }
}

/// A block that is split from above, down to its middle; the gap is 0.04 wide at the top.
Shape notched_block(ElementType type) {
  Shape shape = block(type, 2, 2, 2);
  const auto count = static_cast<Index>(shape.positions.size());
  std::vector<Index> right(count, kNone);
  for (Index v = 0; v < count; ++v) {
    if (shape.positions[v][0] != 1 || shape.positions[v][2] != 2) continue;
    right[v] = static_cast<Index>(shape.positions.size());
    shape.positions.push_back(shape.positions[v] + Vec3(0.02, 0, 0));
    shape.positions[v][0] -= 0.02;
  }
  for (ElementSpec& e : shape.elements) {
    const bool on_the_right =
        std::any_of(e.vertices.begin(), e.vertices.end(), [&](Index v) { return shape.positions[v][0] > 1.5; });
    if (on_the_right) e.renumber([&](Index v) { return v < count && right[v] != kNone ? right[v] : v; });
  }
  return shape;
}

/// What comes within the separation here does so across the outside, while all elements are thick.
TEST(VertexStars, OfNotchesNarrowerThanTheSeparationAreSuspect) {
  SerialExecutor serial;
  for (const ElementType type : {ElementType::tetrahedron, ElementType::hexahedron, ElementType::wedge}) {
    const Shape shape = notched_block(type);
    const Topology topology(shape.mesh());
    const Motion rest = Motion::linear(shape.positions, shape.positions);
    for (const double separation : {0.01, 0.05}) {
      const Step step{topology, rest, kEveryObject, separation};
      VertexStars stars;
      stars.update(step, serial);
      std::size_t in_contact = 0;
      visit_touching(step, [&](std::span<const Index> a, std::span<const Index> b) {
        ++in_contact;
        EXPECT_FALSE(in_a_clear_star(topology.mesh(), stars, a, b)) << to_string(type) << ' ' << separation;
      });
      EXPECT_EQ(in_contact > 0, separation > 0.02) << to_string(type);
      EXPECT_LT(stars.suspects().size(), shape.positions.size() / 2) << to_string(type);
    }
  }
}

/// Wedges around an axis, each `angle` wide. `closed`: the last one has a face in common with the first. Vertices 0 and
/// 1 are the ends of the axis.
Shape fan(Index wedges, double angle, bool closed) {
  Shape shape;
  shape.positions = {Vec3(0, 0, 0), Vec3(0, 0, 1)};
  const Index sides = closed ? wedges : wedges + 1;
  for (Index i = 0; i < sides; ++i)
    for (const double z : {0.0, 1.0})
      shape.positions.emplace_back(std::cos(angle * static_cast<double>(i)), std::sin(angle * static_cast<double>(i)),
                                   z);
  for (Index i = 0; i < wedges; ++i) {
    const Index a = 2 + 2 * i, b = 2 + 2 * ((i + 1) % sides);
    shape.elements.push_back(
        {.type = ElementType::wedge, .vertices = {0, b, a, 1, b + 1, a + 1}, .id = static_cast<std::int64_t>(i)});
  }
  return shape;
}

constexpr double kDegree = 3.14159265358979323846 / 180;

/// Whether the ends of the axis of a fan at rest are suspect.
bool is_wound(const Shape& shape, VertexStars& stars) {
  SerialExecutor serial;
  const Topology topology(shape.mesh());
  stars.update({topology, Motion::linear(shape.positions, shape.positions), kEveryObject}, serial);
  return stars.suspect(0) && stars.suspect(1);
}

/// Two layers of wedges around an axis: vertex 1, in the middle, is inside.
Shape two_layers(Index wedges, double angle) {
  Shape shape = fan(wedges, angle, true);
  const auto lower = static_cast<Index>(shape.positions.size());
  for (Index v = 0; v < lower; v += 2) shape.positions.push_back(shape.positions[v] + Vec3(0, 0, 2));
  const auto above = [&](Index top) { return lower + (top - 1) / 2; };
  for (Index i = 0; i < wedges; ++i) {
    ElementSpec wedge = shape.elements[i];
    const Index b = wedge.vertices[4], a = wedge.vertices[5];
    wedge.vertices = {1, b, a, above(1), above(b), above(a)};
    wedge.id += wedges;
    shape.elements.push_back(wedge);
  }
  return shape;
}

TEST(VertexStars, OfInnerVerticesWoundTwiceAreSuspect) {
  SerialExecutor serial;
  for (const double angle : {60., 120.}) {
    const Shape shape = two_layers(6, angle * kDegree);
    const Topology topology(shape.mesh());
    VertexStars stars;
    stars.update({topology, Motion::linear(shape.positions, shape.positions), kEveryObject}, serial);
    EXPECT_EQ(stars.suspect(1), angle == 120) << angle;
  }
}

/// A tetrahedron that has only the inner vertex of a block in common with it, and lies inside the block.
TEST(VertexStars, WithSomethingInsideAreSuspect) {
  SerialExecutor serial;
  Shape shape = block(ElementType::hexahedron, 2, 2, 2);
  const Vec3 centre(1, 1, 1);
  const auto inner = static_cast<Index>(
      std::find_if(shape.positions.begin(), shape.positions.end(), [&](const Vec3& p) { return p == centre; }) -
      shape.positions.begin());
  ElementSpec tetrahedron{.type = ElementType::tetrahedron, .vertices = {inner}, .id = 8};
  for (const Vec3& way : {Vec3(0.5, 0.1, 0.1), Vec3(0.1, 0.5, 0.1), Vec3(0.1, 0.1, 0.5)}) {
    tetrahedron.vertices.push_back(static_cast<Index>(shape.positions.size()));
    shape.positions.push_back(centre + way);
  }
  VertexStars stars;
  for (const bool inside : {false, true}) {
    if (inside) shape.elements.push_back(tetrahedron);
    const Topology topology(shape.mesh());
    stars.update({topology, Motion::linear(shape.positions, shape.positions), kEveryObject}, serial);
    EXPECT_EQ(stars.suspect(inner), inside);
  }
}

TEST(VertexStars, WoundTwiceAreSuspect) {
  for (const auto& [wedges, angle, closed, wound] :
       {std::tuple{6u, 60., true, false}, {6u, 120., true, true}, {3u, 100., false, false}, {4u, 100., false, true}}) {
    VertexStars stars;
    EXPECT_EQ(is_wound(fan(wedges, angle * kDegree, closed), stars), wound) << wedges << " of " << angle;
  }
}

/// All volumes are positive in both steps; on the way between them they are not.
TEST(VertexStars, AreCheckedAgainAfterAJump) {
  SerialExecutor serial;
  const Shape once = fan(6, 60 * kDegree, true), twice = fan(6, 120 * kDegree, true);
  const Topology topology(once.mesh());
  VertexStars stars;
  stars.update({topology, Motion::linear(once.positions, once.positions), kEveryObject}, serial);
  EXPECT_TRUE(stars.suspects().empty());
  stars.update({topology, Motion::linear(twice.positions, twice.positions), kEveryObject}, serial);
  EXPECT_TRUE(stars.suspect(0) && stars.suspect(1));
}

/// The same for stars on a cut, if the jump is in a step that has no stars on a cut, or if another part of the mesh
/// follows it.
TEST(VertexStars, OfACutAreCheckedAgainAfterAJump) {
  SerialExecutor serial;
  const Shape once = fan(6, 60 * kDegree, true), twice = fan(6, 120 * kDegree, true);
  const Motion before = Motion::linear(once.positions, once.positions),
               after = Motion::linear(twice.positions, twice.positions);
  const Topology whole(once.mesh());
  const test::Cut first(whole, [](Index o) { return o != 0; }), second(whole, [](Index o) { return o != 1; });
  const auto step_of = [&](const test::Cut& part, const Motion& motion) {
    Step step{part.topology, motion, kEveryObject};
    step.piece = {.complete = part.complete, .cut_stars = &whole};
    return step;
  };
  VertexStars stars;
  stars.update(step_of(first, before), serial);
  EXPECT_TRUE(stars.suspects().empty());
  stars.update({first.topology, after, kEveryObject}, serial);
  stars.update(step_of(first, after), serial);
  EXPECT_TRUE(stars.suspect(0) && stars.suspect(1)) << "without stars on the cut";

  stars.update(step_of(first, before), serial);
  EXPECT_TRUE(stars.suspects().empty());
  stars.update(step_of(second, after), serial);
  EXPECT_TRUE(stars.suspect(0) && stars.suspect(1)) << "another part";
}

TEST(VertexStars, AreCheckedAgainAfterAnEdit) {
  SerialExecutor serial;
  const Shape whole = fan(4, 100 * kDegree, false);
  Shape begun = whole;
  begun.elements.pop_back();
  Topology topology(begun.mesh());
  const Motion motion = Motion::linear(whole.positions, whole.positions);
  VertexStars stars;
  stars.update({topology, motion, kEveryObject}, serial);
  EXPECT_FALSE(stars.suspect(0) || stars.suspect(1));
  topology.apply({{}, {}, {whole.elements.back()}});
  stars.update({topology, motion, kEveryObject}, serial);
  EXPECT_TRUE(stars.suspect(0) && stars.suspect(1));
}

/// A crack opens a closed star: after the edit the vertices at its end are suspect, the others are not.
TEST(VertexStars, FollowEdits) {
  SerialExecutor serial;
  const Shape shape = block(ElementType::hexahedron, 3, 3, 3);
  Topology kept(shape.mesh());
  const Motion motion = Motion::linear(shape.positions, shape.positions);
  VertexStars stars;
  stars.update({kept, motion, kEveryObject}, serial);
  EXPECT_TRUE(stars.suspects().empty());
  kept.apply({{0, 13}, {}, {}});
  stars.update({kept, motion, kEveryObject}, serial);
  VertexStars fresh;
  fresh.update({kept, motion, kEveryObject}, serial);
  EXPECT_EQ(stars.suspects(), fresh.suspects());
  EXPECT_FALSE(fresh.suspects().empty());
}

TEST(VertexStars, AnInterruptedStepIsBegunAnew) {
  SerialExecutor serial;
  const auto suspects = [&](int interrupted) {
    VertexStars stars;
    for (const int n : {3, 2}) {
      const JitteredBlock block(ElementType::hexahedron, n, 0.25, 5);
      if (n == 2 && interrupted >= 0) {
        EndsInLoop executor(interrupted);
        EXPECT_THROW(stars.update(block.step(), executor), std::runtime_error) << interrupted;
      }
      stars.update(block.step(), serial);
    }
    return stars.suspects();
  };
  for (int loop = 0; loop < 6; ++loop) EXPECT_EQ(suspects(loop), suspects(-1)) << loop;
}

/// What was known of another mesh does not survive, either.
TEST(VertexStars, AnInterruptedStepLeavesNothingOfAnotherMesh) {
  SerialExecutor serial;
  const Shape twice = fan(6, 120 * kDegree, true);
  const Topology topology(twice.mesh());
  const Motion rest = Motion::linear(twice.positions, twice.positions);
  for (int loop = 0; loop < 6; ++loop) {
    VertexStars stars;
    EXPECT_FALSE(is_wound(fan(6, 60 * kDegree, true), stars));
    EndsInLoop executor(loop);
    EXPECT_THROW(stars.update({topology, rest, kEveryObject}, executor), std::runtime_error) << loop;
    stars.update({topology, rest, kEveryObject}, serial);
    EXPECT_TRUE(stars.suspect(0) && stars.suspect(1)) << loop;
  }
}

}  // namespace
}  // namespace volccd::detail
