// The list of initial overlaps does not depend on the pipeline.
#include <gtest/gtest.h>

#include <volccd/narrowphase/overlap/initial_overlap.hpp>
#include <volccd/pipelines/pipeline.hpp>

#include "pipelines/scenes.hpp"

namespace volccd {
namespace {

using test::registry;
using test::Scene;
using Pairs = std::vector<ElementPair>;

StepResult run(const PipelineSpec& spec, const Step& step, const Request& request, Executor* executor = nullptr) {
  static SerialExecutor serial;
  const Pipeline pipeline(registry(), spec);
  Workspace workspace = pipeline.make_workspace();
  StepResult result;
  pipeline.run(step, workspace, executor ? *executor : serial, result, request);
  return result;
}

PipelineSpec with(const char* pipeline, std::initializer_list<const char*> settings) {
  PipelineSpec spec = registry().pipeline(pipeline);
  for (const char* setting : settings) {
    registry().apply_setting(spec, setting);
    spec.name += std::string(" ") + setting;
  }
  return spec;
}

/// The presets, every broad phase, and every way in which element culling may drop a pair.
std::vector<PipelineSpec> specs() {
  std::vector<PipelineSpec> all = registry().pipelines();
  for (const char* broad : {"broad-phase=kdop-bvh", "broad-phase=spatial-hash", "broad-phase=brute-force"}) {
    all.push_back(with("VolCCD", {broad, "csat.mode=both", "csat.axis=optimal"}));
    all.push_back(with("VolCCD+", {broad, "element-culling=none"}));
    all.push_back(with("VolCCD+", {broad, "csat.axis=centroid"}));
  }
  return all;
}

/// The definition, applied to all pairs of elements.
Pairs expected(const Step& step) {
  const Mesh& mesh = step.mesh();
  const auto points = [&](Index o) {
    std::vector<Vec3> result;
    for (const Index v : mesh.vertices(o)) result.push_back(step.motion.point(v, 0));
    return result;
  };
  const auto adjacent = [&](Index a, Index b) {
    for (const Index v : mesh.vertices(a))
      for (const Index w : mesh.vertices(b))
        if (v == w) return true;
    return false;
  };
  InitialOverlapTest test;
  Pairs result;
  for (Index a = 0; a < mesh.element_slots(); ++a)
    for (Index b = a + 1; b < mesh.element_slots(); ++b)
      if (mesh.is_live(a) && mesh.is_live(b) && !adjacent(a, b) && step.filter.allows(mesh.object(a), mesh.object(b)) &&
          test.overlap(points(a), points(b), step.separation))
        result.push_back({a, b});
  return result;
}

/// Two blocks that touch exactly, or overlap, with little motion.
Scene stacked(const Shape& shape, const Vec3& by, double jitter) {
  Shape both;
  both.append(shape, 1);
  Shape other = shape;
  both.append(other.translate(by), 2);
  const Shape mixed = permuted(both, 5);
  return {"stacked", Topology(mixed.mesh()),
          Motion::linear(jittered(mixed.positions, jitter, 6), jittered(mixed.positions, 0.01, 7))};
}

std::vector<Scene> scenes() {
  std::vector<Scene> all = test::small_scenes(7, 0.35);
  for (const ElementType type : {ElementType::tetrahedron, ElementType::hexahedron, ElementType::polytope})
    for (const double z : {1.0, 0.75, std::nextafter(1.0, 2.0)})
      all.push_back(stacked(block(type, 2, 2, 1), Vec3(0.5, 0.25, z), 0));
  all.push_back(stacked(mixed_block(1, 1), Vec3(0.1, 0.2, 0.3), 0.05));
  return all;
}

TEST(InitialOverlaps, EveryPipelineListsWhatTheDefinitionSays) {
  std::size_t listed = 0;
  for (const Scene& scene : scenes()) {
    const ObjectFilter everything;
    const Step step{scene.topology, scene.motion, everything};
    const Pairs truth = expected(step);
    listed += truth.size();
    for (const PipelineSpec& spec : specs()) {
      const StepResult result = run(spec, step, {.initial_overlaps = true});
      EXPECT_EQ(result.initial_overlaps, truth) << scene.name << " " << spec.name;
      EXPECT_EQ(result.statistics.initial_overlaps, truth.size());
      EXPECT_EQ(result.statistics.stages.back().out, truth.size());
    }
  }
  EXPECT_GT(listed, 200u);
}

TEST(InitialOverlaps, ScopesSeparationFirstAndThreads) {
  const Scene scene = stacked(mixed_block(1, 1), Vec3(0.1, 0.2, 0.3), 0.05);
  const auto threads = make_thread_executor(3);
  for (const PairScope scope : {PairScope::all, PairScope::inter, PairScope::intra}) {
    const ObjectFilter filter(scope);
    const Step step{scene.topology, scene.motion, filter};
    const Pairs truth = expected(step);
    EXPECT_EQ(truth.empty(), scope == PairScope::intra);
    for (const PipelineSpec& spec : specs()) {
      EXPECT_EQ(run(spec, step, {.query = Query::first, .initial_overlaps = true}, threads.get()).initial_overlaps,
                truth)
          << spec.name;
      EXPECT_TRUE(run(spec, step, {}).initial_overlaps.empty()) << spec.name;
      Step short_step = step;
      short_step.t_max = 0.01;
      EXPECT_EQ(run(spec, short_step, {.initial_overlaps = true}).initial_overlaps, truth) << spec.name;
    }
  }
}

TEST(InitialOverlaps, ElementsOfTwoObjectsThatShareVertices) {
  Shape shape = block(ElementType::tetrahedron, 3, 2, 2);
  for (std::size_t i = 0; i < shape.elements.size(); ++i) shape.elements[i].object = i % 3 == 0 ? 1 : 2;
  const Scene scene{"shared", Topology(shape.mesh()),
                    Motion::linear(jittered(shape.positions, 0.6, 4), jittered(shape.positions, 0.6, 5))};
  for (const PairScope scope : {PairScope::inter, PairScope::intra}) {
    const ObjectFilter filter(scope);
    const Step step{scene.topology, scene.motion, filter};
    const Pairs truth = expected(step);
    EXPECT_GT(truth.size(), 5u);
    for (const PipelineSpec& spec : specs())
      EXPECT_EQ(run(spec, step, {.initial_overlaps = true}).initial_overlaps, truth) << spec.name;
  }
}

/// A tetrahedron, and a needle that pierces two of its faces, touches none of its edges and has no vertex inside; or a
/// small tetrahedron inside.
Scene pierced(bool needle) {
  Shape shape;
  shape.positions = {{-4, -4, 0}, {4, -4, 0}, {0, 5, 0}, {0, 0, 6}};
  if (needle)
    shape.positions.insert(shape.positions.end(), {{-0.1, 0.1, -3}, {0.1, 0.1, -3}, {0, -0.1, -3}, {0.3, 1.2, 9}});
  else
    shape.positions.insert(shape.positions.end(), {{0, 0, 1}, {0.1, 0, 1}, {0, 0.1, 1}, {0, 0, 1.1}});
  shape.elements = {{.type = ElementType::tetrahedron, .vertices = {0, 1, 2, 3}, .object = 1},
                    {.type = ElementType::tetrahedron, .vertices = {4, 5, 6, 7}, .object = 2, .id = 1}};
  std::vector<Vec3> end = shape.positions;
  for (Vec3& p : end) p.x() += 0.01;
  return {needle ? "pierced" : "inside", Topology(shape.mesh()), Motion::linear(shape.positions, end)};
}

TEST(InitialOverlaps, InsideAndPiercedAreFoundWhateverElementCullingDrops) {
  const ObjectFilter everything;
  for (const bool needle : {false, true}) {
    const Scene scene = pierced(needle);
    const Step step{scene.topology, scene.motion, everything};
    for (const PipelineSpec& spec : specs())
      EXPECT_EQ(run(spec, step, {.initial_overlaps = true}).initial_overlaps, (Pairs{{0, 1}}))
          << scene.name << " " << spec.name;
  }
}

TEST(InitialOverlaps, RunningAgainGivesTheSame) {
  const Scene scene = stacked(block(ElementType::hexahedron, 2, 2, 1), Vec3(0.5, 0.25, 0.75), 0);
  const ObjectFilter everything;
  const Step step{scene.topology, scene.motion, everything};
  const Pipeline pipeline(registry(), registry().pipeline("VolCCD+"));
  Workspace workspace = pipeline.make_workspace();
  SerialExecutor serial;
  StepResult result;
  for (int i = 0; i < 3; ++i) {
    pipeline.run(step, workspace, serial, result, {.initial_overlaps = i != 1});
    EXPECT_EQ(result.initial_overlaps, i != 1 ? expected(step) : Pairs{});
  }
}

}  // namespace
}  // namespace volccd
