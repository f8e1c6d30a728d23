// Which elements a rank receives at vertices that it asks for, and which vertices it knows to be complete.
#include <volccd/distributed/detail/lists.hpp>

#include <algorithm>
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

/// A vertex that a rank takes for complete has all its elements there, with any skin; some vertices are not complete.
TEST(ElementsAt, VerticesAreCompleteOnlyWithAllElements) {
  for (const cases::Scene& scene : cases::small_scenes(5, 0.05))
    for (const double skin : {0.0, 0.5}) {
      const Topology& topology = scene.topology;
      const Mesh& mesh = topology.mesh();
      std::size_t complete = 0, cut = 0;
      InProcessRanks(4).run([&](Exchange& exchange) {
        Home given(exchange, mesh);
        Motion own(static_cast<Index>(given.home.vertices().size()), 2);
        for (Index i = 0; i < own.vertex_count(); ++i) {
          const auto ids = mesh.vertex_ids();
          const auto v = std::ranges::lower_bound(ids, given.home.vertices()[i]) - ids.begin();
          for (int c = 0; c < 2; ++c) own.set(i, c, scene.motion.point(static_cast<Index>(v), c));
        }
        given.home.update(own);
        given.home.make_boxes(0.01, serial_executor());
        const std::vector<MotionBox> boxes = given.home.element_boxes(serial_executor());
        const Regions regions = detail::divide(exchange, boxes, {}, {});
        double seconds = 0;
        const ReceivedElements found = detail::distribute(
            exchange, given.home, boxes, detail::Targets(given.home, boxes, skin, regions), regions, seconds);
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

}  // namespace
}  // namespace volccd::distributed
