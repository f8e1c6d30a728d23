// Which elements a rank receives, which vertices it knows to be complete, and how long its lists hold.
#include <volccd/distributed/detail/lists.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/distributed/detail/owners.hpp>
#include <volccd/distributed/in_process_exchange.hpp>
#include <volccd/distributed/parts.hpp>
#include <volccd/oracle/cases/colliding_scenes.hpp>

namespace volccd::distributed {
namespace {

std::vector<std::int64_t> sorted(std::vector<std::int64_t> ids) {
  std::ranges::sort(ids);
  return ids;
}

/// A rank that gives an equal part of the elements, and vertices that have nothing to do with them.
struct Home {
  Home(Exchange& exchange, const Mesh& mesh)
      : home(exchange, elements_in(mesh, part_of(mesh.element_slots(), exchange.rank(), exchange.size())),
             vertices_of(exchange, mesh), EdgeSet::triangulated) {}

  static std::vector<std::int64_t> vertices_of(Exchange& exchange, const Mesh& mesh) {
    std::vector<std::int64_t> ids;
    for (Index v = 0; v < mesh.vertex_count(); ++v)
      if (static_cast<int>((7 * v) % static_cast<Index>(exchange.size())) == exchange.rank())
        ids.push_back(mesh.vertex_id(v));
    return ids;
  }

  detail::Home home;
};

TEST(ElementsAt, AreAllThatHaveTheVertices) {
  for (const cases::Scene& scene : cases::small_scenes(5, 0.1)) {
    const Mesh& mesh = scene.topology.mesh();
    InProcessRanks(5).run([&](Exchange& exchange) {
      const Home given(exchange, mesh);
      Random random(static_cast<std::uint64_t>(exchange.rank()) + 1);
      std::vector<std::int64_t> asked, expected;
      std::vector<char> is_asked(mesh.vertex_count(), 0);
      for (Index v = 0; v < mesh.vertex_count(); ++v) {
        if (exchange.rank() == 0 || random.below(3) != 0) continue;  // rank 0 asks for nothing
        asked.push_back(mesh.vertex_id(v));
        is_asked[v] = 1;
      }
      for (Index o = 0; o < mesh.element_slots(); ++o)
        if (std::ranges::any_of(mesh.vertices(o), [&](Index v) { return is_asked[v] != 0; }))
          expected.push_back(mesh.element_id(o));
      double seconds = 0;
      const std::vector<int> owners = detail::find_owners(exchange, "vertex", given.home.vertices(), asked);
      const ReceivedElements found = detail::elements_at(exchange, given.home, asked, owners, seconds);
      EXPECT_EQ(sorted(found.elements.ids), sorted(expected)) << scene.name << ", rank " << exchange.rank();
      EXPECT_EQ(found.owners, detail::find_owners(exchange, "vertex", given.home.vertices(), found.elements.vertices));
    });
  }
}

/// Cuts by measured times, where elements that follow each other are on opposite sides, and each sample stands for
/// several elements.
TEST(Divide, WeighsElementsByTheirOwnRegions) {
  InProcessRanks(2).run([&](Exchange& exchange) {
    Random random(static_cast<std::uint64_t>(exchange.rank()) + 1);
    std::vector<MotionBox> boxes;
    for (int i = 0; i < 100'000; ++i) {
      const Vec3 point((i % 2) + random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1));
      boxes.push_back({point, point});
    }
    const Regions equal = detail::divide(exchange, boxes, {}, {});
    EXPECT_NEAR(equal.region(0).high[0], 1, 0.02);
    const Regions weighed = detail::divide(exchange, boxes, equal, std::vector<double>{3, 1});
    EXPECT_NEAR(weighed.region(0).high[0], 2.0 / 3, 0.02) << "as much below as from there on: 3 (1 - x) + 1 = 3 x";
  });
}

/// The motion of a rank's vertices: those of the scene, of which one (of all ranks) or all are displaced by up to
/// `amount`.
Motion motion_of(const Home& given, const cases::Scene& scene, double amount, std::uint64_t seed) {
  Random random(seed);
  const bool all = random.below(2) == 0;
  const Index one = static_cast<Index>(random.below(scene.topology.mesh().vertex_count()));
  Motion own(static_cast<Index>(given.home.vertices().size()), 2);
  for (Index i = 0; i < own.vertex_count(); ++i) {
    const auto ids = scene.topology.mesh().vertex_ids();
    const auto v = static_cast<Index>(std::ranges::lower_bound(ids, given.home.vertices()[i]) - ids.begin());
    const Vec3 by = amount * Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    for (int c = 0; c < 2; ++c) own.set(i, c, scene.motion.point(v, c) + (all || v == one ? by : Vec3(0, 0, 0)));
  }
  return own;
}

/// A vertex that a rank takes for complete has all its elements there, with any skin; some vertices are not complete.
TEST(ElementsAt, VerticesAreCompleteOnlyWithAllElements) {
  for (const cases::Scene& scene : cases::small_scenes(5, 0.05))
    for (const double skin : {0.0, 0.5}) {
      const Topology& topology = scene.topology;
      const Mesh& mesh = topology.mesh();
      std::size_t complete = 0, cut = 0;
      InProcessRanks(4).run([&](Exchange& exchange) {
        Home given(exchange, mesh);
        given.home.update(motion_of(given, scene, 0, 1));
        given.home.make_boxes(0.01, serial_executor());
        const std::vector<MotionBox> boxes = given.home.element_boxes(serial_executor());
        const Regions regions = detail::divide(exchange, boxes, {}, {});
        const detail::Targets targets(given.home, boxes, skin, regions);
        double seconds = 0;
        const ReceivedElements found = detail::distribute(exchange, given.home, boxes, targets, regions, seconds);
        for (std::size_t i = 0; i < found.elements.vertices.size(); ++i) {
          const std::int64_t id = found.elements.vertices[i];
          const auto slot =
              static_cast<Index>(std::ranges::lower_bound(mesh.vertex_ids(), id) - mesh.vertex_ids().begin());
          const auto held = std::ranges::count(found.elements.vertices, id);
          const auto all = static_cast<std::ptrdiff_t>(topology.features().vertex_elements(slot).size());
          EXPECT_TRUE(found.complete[i] == 0 || held == all) << scene.name << ", skin " << skin;
          ++(found.complete[i] != 0 ? complete : cut);
        }
      });
      EXPECT_GT(complete, 10u) << scene.name;
      EXPECT_GT(cut, 0u) << scene.name;
    }
}

/// Lists hold exactly while no box meets another region, whether vertices are within their limits or not.
TEST(Targets, CoverBoxesThatMeetTheSameRegions) {
  std::size_t covered = 0, left = 0;
  for (const ElementType type : {ElementType::tetrahedron, ElementType::hexahedron})
    for (const double skin : {0.0, 0.1, 0.3}) {
      const cases::Scene scene = cases::colliding(to_string(type), block(type, 4, 3, 3), 5, 0.05);
      InProcessRanks(6).run([&](Exchange& exchange) {
        Home given(exchange, scene.topology.mesh());
        given.home.update(motion_of(given, scene, 0, 1));
        given.home.make_boxes(0.01, serial_executor());
        const std::vector<MotionBox> boxes = given.home.element_boxes(serial_executor());
        const Regions regions = detail::divide(exchange, boxes, {}, {});
        const detail::Targets targets(given.home, boxes, skin, regions);
        for (std::uint64_t k = 0; k < 200; ++k) {
          given.home.update(motion_of(given, scene, k == 0 ? 0 : std::exp2(-static_cast<double>(k % 8)), k));
          given.home.make_boxes(0.01, serial_executor());
          bool expected = true;
          for (std::size_t i = 0; i < targets.size(); ++i)
            regions.meeting(given.home.element_box(i), [&](int r) {
              expected = expected && std::ranges::find(targets[i], r) != targets[i].end();
            });
          EXPECT_EQ(targets.cover(given.home, regions), expected) << scene.name << ", skin " << skin << ", " << k;
          ++(expected ? covered : left);
        }
      });
    }
  EXPECT_GT(covered, 500u);
  EXPECT_GT(left, 500u);
}

}  // namespace
}  // namespace volccd::distributed
