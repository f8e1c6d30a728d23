// The scene weld: its model, and that its plates merge and split by stress.
#include <volccd/experiments/scenes/simulated/weld.hpp>

#include <gtest/gtest.h>

#include <cmath>

#include <volccd/core/error.hpp>
#include <volccd/core/executor.hpp>
#include <volccd/experiments/harness/corner_volumes.hpp>
#include <volccd/experiments/scenes/simulated/simulated_scene.hpp>

namespace volccd {
namespace {

using simulation::Model;

TEST(Weld, ModelsAreTwoPlatesApart) {
  for (const int elements : {300, kWeldQuickElements, kWeldElements, 20'000}) {
    const Model model = weld_model(elements, 1);
    EXPECT_NEAR(static_cast<double>(model.mesh.element_count()), elements, 0.35 * elements);
    double flyer = 1, target = -1;
    for (Index o = 0; o < model.mesh.element_slots(); ++o) {
      ASSERT_EQ(model.mesh.type(o), ElementType::hexahedron);
      for (const auto& corner : corner_tetrahedra(ElementType::hexahedron))
        ASSERT_GT(corner_volume(corner, model.mesh.vertices(o), model.positions), 0);
      for (const Index v : model.mesh.vertices(o)) {
        EXPECT_EQ(model.velocities[v].z(), model.mesh.object(o) == 0 ? -300 : 0);
        const double z = model.positions[v].z();
        (model.mesh.object(o) == 0 ? flyer : target) =
            model.mesh.object(o) == 0 ? std::min(flyer, z) : std::max(target, z);
      }
    }
    EXPECT_NEAR(flyer - target, 0.0001, 1e-9);
  }
  EXPECT_EQ(weld_model(800, 3).positions, weld_model(800, 3).positions);
  EXPECT_NE(weld_model(800, 3).positions, weld_model(800, 4).positions);
  EXPECT_THROW(weld_model(299), ConfigError);
  EXPECT_THROW(weld_model(1'000'001), ConfigError);
}

/// Number of vertices that elements of both parts have.
std::size_t common_vertices(const Topology& topology) {
  std::size_t count = 0;
  for (Index v = 0; v < topology.features().vertex_slots(); ++v) {
    bool part[2] = {false, false};
    for (const Index o : topology.features().vertex_elements(v)) part[topology.mesh().object(o)] = true;
    count += part[0] && part[1] ? 1 : 0;
  }
  return count;
}

TEST(Weld, PlatesMergeUnderTheContactAndSplitUnderTheReflectedWave) {
  const SimulatedScene& scene = *find_simulated_scene("weld");
  const auto executor = make_executor(2);
  simulation::Simulation run(weld_model(kWeldQuickElements), scene.options, *executor);
  run.advance_to(0.3e-6);  // before the impact, and before a wave returns
  simulation::SimulationCounts counts = run.drain_counts();
  EXPECT_EQ(counts.merges + counts.splits, 0u);
  EXPECT_EQ(common_vertices(run.topology()), 0u);
  run.advance_to(scene.duration / 2);
  counts = run.drain_counts();
  EXPECT_GT(counts.merges, 10u);
  EXPECT_GT(counts.splits, 50u);
  EXPECT_GT(common_vertices(run.topology()), 10u);
  EXPECT_LT(std::abs(run.ledger().balance_error()), 0.03 * run.ledger().initial);
  // The fragment that spalls at the back moves ahead of the plate.
  double fastest = 0;
  for (Index o = 0; o < run.topology().mesh().element_slots(); ++o)
    if (run.topology().mesh().is_live(o) && run.topology().mesh().object(o) == 1)
      for (const Index v : run.topology().mesh().vertices(o)) fastest = std::min(fastest, run.velocities()[v].z());
  EXPECT_LT(fastest, -85) << "all together have 61 m/s: 200 of 984 cubes had 300 m/s";
}

}  // namespace
}  // namespace volccd
