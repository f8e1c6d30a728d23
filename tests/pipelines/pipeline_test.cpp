// Whole pipelines are conservative and deterministic.
#include <volccd/pipelines/pipeline.hpp>

#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <volccd/core/random.hpp>
#include <volccd/numerics/kdop.hpp>
#include <volccd/pipelines/compare.hpp>

#include "pipelines/scenes.hpp"

namespace volccd {
namespace {

using test::registry;
using test::Scene;

const ObjectFilter kEverything;

StepResult run(const PipelineSpec& spec, const Scene& scene, Query query = Query::all,
               const ObjectFilter& filter = kEverything, Executor* executor = nullptr) {
  static SerialExecutor serial;
  const Pipeline pipeline(registry(), spec);
  Workspace workspace = pipeline.make_workspace();
  StepResult result;
  pipeline.run({scene.topology, scene.motion, filter}, workspace, executor ? *executor : serial, result,
               {.query = query});
  return result;
}

/// All pairs of elements, without boxes, so that nothing is culled.
PipelineSpec reference(const char* narrow_phase = "inclusion") {
  PipelineSpec spec = registry().pipeline("BruteForce");
  spec.broad_phase.options["bounds"] = "none";
  spec.narrow_phase.name = narrow_phase;
  return spec;
}

std::string summary(const ContactDifference& d) {
  return std::to_string(d.missing.size()) + " missing, " + std::to_string(d.extra.size()) + " extra, " +
         std::to_string(d.changed.size()) + " changed";
}

void expect_same(const StepResult& expected, const StepResult& found, const std::string& what) {
  const ContactDifference d = compare_contacts(expected.contacts, found.contacts);
  EXPECT_TRUE(d.empty()) << what << ": " << summary(d);
}

/// All sound combinations of stages: broad phase x element culling x assignment and orphans x feature filters.
std::vector<PipelineSpec> combinations() {
  const std::vector<std::vector<StageChoice>> element = {{},
                                                         {{"csat", {{"axis", "face"}, {"mode", "features"}}}},
                                                         {{"csat", {{"axis", "predetermined"}, {"mode", "pair"}}}},
                                                         {{"csat", {{"axis", "velocity"}, {"mode", "both"}}}},
                                                         {{"csat", {{"axis", "centroid"}, {"mode", "pair"}}}},
                                                         {{"csat", {{"axis", "optimal"}, {"mode", "pair"}}}},
                                                         {{"csat", {{"axis", "optimal"}, {"mode", "both"}}}}};
  const StageChoice minimal{"o-set", {{"kind", "minimal"}}}, literal{"o-set", {{"kind", "literal"}}};
  const std::vector<std::pair<StageChoice, std::optional<StageChoice>>> tests = {
      {{"all-pairs", {}}, {}},         {{"all-pairs", {}}, minimal},          {{"all-pairs", {}}, literal},
      {{"static-assignment", {}}, {}}, {{"dynamic-assignment", {}}, minimal}, {{"dynamic-assignment", {}}, literal}};
  const std::vector<std::vector<StageChoice>> filters = {
      {},
      {{"feature-kdop", {}}},
      {{"coplanarity", {}}},
      {{"feature-csat", {}}},
      {{"feature-kdop", {}}, {"coplanarity", {}}, {"feature-csat", {}}}};
  std::vector<PipelineSpec> specs;
  for (const char* broad : {"kdop-bvh", "spatial-hash", "brute-force"})
    for (const auto& e : element)
      for (const auto& [assignment, orphans] : tests)
        for (const auto& t : filters) {
          PipelineSpec spec{broad, "", {broad, {}}, e, assignment, orphans, t, {"inclusion", {}}};
          spec.name += (e.empty() ? "" : "/" + e[0].options.at("axis") + "-" + e[0].options.at("mode")) + "/" +
                       assignment.name + (orphans ? "-" + orphans->options.at("kind") : "") + "/" +
                       std::to_string(t.size()) + (t.size() == 1 ? t[0].name : "");
          specs.push_back(spec);
        }
  return specs;
}

TEST(Pipelines, EveryPresetFindsTheContactsOfBruteForce) {
  for (const double jitter : {0.02, 0.35})
    for (const Scene& scene : test::small_scenes(7, jitter)) {
      std::map<std::string, StepResult> expected;
      for (const char* narrow : {"inclusion", "provot"}) expected[narrow] = run(reference(narrow), scene);
      EXPECT_GT(expected["inclusion"].contacts.size(), 10u) << scene.name;
      EXPECT_EQ(expected["inclusion"].contacts.size(), expected["provot"].contacts.size()) << scene.name;
      for (const PipelineSpec& spec : registry().pipelines())
        expect_same(expected.at(spec.narrow_phase.name), run(spec, scene), scene.name + " " + spec.name);
    }
}

TEST(Pipelines, EveryBroadPhaseCombinesWithEveryStage) {
  const Scene scene = test::colliding("mixed", mixed_block(1, 1), 3, 0.3);
  const StepResult expected = run(reference(), scene);
  for (const PipelineSpec& spec : combinations()) expect_same(expected, run(spec, scene), spec.name);
}

TEST(LongPipelines, EveryBroadPhaseCombinesWithEveryStageOnEveryType) {
  for (const std::uint64_t seed : {11u, 12u})
    for (const Scene& scene : test::small_scenes(seed, 0.3)) {
      const StepResult expected = run(reference(), scene);
      for (const PipelineSpec& spec : combinations())
        expect_same(expected, run(spec, scene), scene.name + " " + spec.name);
    }
}

TEST(Pipelines, ExactlyOnceMeansNoDuplicates) {
  for (const Scene& scene : test::small_scenes(5, 0.3)) {
    for (const char* name : {"VolCCD", "VolCCD+"})
      EXPECT_EQ(run(registry().pipeline(name), scene).statistics.duplicates, 0u) << scene.name << " " << name;
    EXPECT_GT(run(registry().pipeline("NavCCD"), scene).statistics.duplicates, 0u) << scene.name;
  }
}

TEST(ThreadsPipelines, SameResultAndCountsForAnyNumberOfWorkers) {
  const Scene scene = test::colliding("tetrahedra", block(ElementType::tetrahedron, 4, 4, 2), 9, 0.2);
  for (const PipelineSpec& spec : registry().pipelines()) {
    const StepResult serial = run(spec, scene);
    for (const unsigned threads : {1u, 3u}) {
      const auto executor = make_thread_executor(threads);
      const StepResult parallel = run(spec, scene, Query::all, kEverything, executor.get());
      expect_same(serial, parallel, spec.name + " with " + std::to_string(threads));
      EXPECT_EQ(serial.statistics.element_pairs, parallel.statistics.element_pairs);
      EXPECT_EQ(serial.statistics.vf_tests, parallel.statistics.vf_tests);
      EXPECT_EQ(serial.statistics.ee_tests, parallel.statistics.ee_tests);
      EXPECT_EQ(serial.statistics.duplicates, parallel.statistics.duplicates);
    }
  }
}

TEST(Pipelines, TbbGivesTheSameAsOneThread) {
  const Scene scene = test::colliding("hexahedra", block(ElementType::hexahedron, 3, 3, 2), 9, 0.2);
  const auto executor = make_executor(3);
  for (const PipelineSpec& spec : registry().pipelines())
    expect_same(run(spec, scene), run(spec, scene, Query::all, kEverything, executor.get()), spec.name);
}

void expect_first_is_earliest(const Scene& scene, Executor* executor) {
  for (const PipelineSpec& spec : registry().pipelines()) {
    const StepResult all = run(spec, scene);
    const StepResult first = run(spec, scene, Query::first, kEverything, executor);
    ASSERT_EQ(first.contacts.size(), all.contacts.empty() ? 0u : 1u) << scene.name << " " << spec.name;
    if (all.contacts.empty()) continue;
    const Contact* earliest = &all.contacts.front();
    for (const Contact& c : all.contacts)
      if (c.toi < earliest->toi) earliest = &c;
    EXPECT_TRUE(first.contacts.front() == *earliest) << scene.name << " " << spec.name;
  }
}

TEST(Pipelines, FirstIsTheEarliestOfAll) {
  for (const double jitter : {0.0, 0.02, 0.2})
    for (const Scene& scene : test::small_scenes(21, jitter)) expect_first_is_earliest(scene, nullptr);
}

TEST(ThreadsPipelines, FirstIsTheEarliestOfAll) {
  const auto executor = make_thread_executor(3);
  for (const Scene& scene : test::small_scenes(21, 0.2)) expect_first_is_earliest(scene, executor.get());
}

/// Pairs of tetrahedra, far from each other, of which a vertex reaches a face of the other at about t = 1/2. The times
/// differ by up to `spread`.
Scene nearly_simultaneous(std::size_t pairs, double spread, std::uint64_t seed) {
  Random random(seed);
  const auto any = [&] { return Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)); };
  Shape shape;
  std::vector<Vec3> x1;
  for (std::size_t pair = 0; pair < pairs; ++pair) {
    const Vec3 place(static_cast<double>(20 * (pair % 32)), static_cast<double>(20 * (pair / 32)), 0);
    const auto turn = Eigen::AngleAxisd(random.uniform(0, 6), any().normalized());
    const Vec3 point = Vec3(0.2, 0.3, 0) + 0.2 * any(), at(point.x(), point.y(), 0);
    const double time = 0.5 + spread * random.uniform();
    const Vec3 motion(random.uniform(-1, 1), random.uniform(-1, 1), -random.uniform(1, 2));
    const Vec3 tip = at - time * motion;
    const Vec3 corners[2][4] = {{{-1, -1, 0}, {3, -1, 0}, {-1, 3, 0}, {0, 0, -1}},
                                {tip, tip + Vec3(1, 0, 2), tip + Vec3(0, 1, 2), tip + Vec3(-1, -1, 2)}};
    for (std::size_t e = 0; e < 2; ++e) {
      ElementSpec element{.type = ElementType::tetrahedron, .id = static_cast<std::int64_t>(2 * pair + e)};
      for (const Vec3& p : corners[e]) {
        element.vertices.push_back(static_cast<Index>(shape.positions.size()));
        shape.positions.push_back(place + turn * p);
        x1.push_back(place + turn * (e == 1 ? Vec3(p + motion) : p));
      }
      shape.elements.push_back(element);
    }
  }
  std::vector<Vec3> middle = shape.positions;  // quadratic, because times are less exact
  for (std::size_t v = 0; v < middle.size(); ++v) middle[v] = (middle[v] + x1[v]) / 2;
  return {"nearly simultaneous", Topology(shape.mesh()), Motion::quadratic(shape.positions, middle, x1)};
}

/// Reports contacts early by up to its tolerance, which is much larger than that of other narrow phases: by a fraction
/// of it that depends on the vertices.
class EarlyTimes final : public NarrowPhase {
 public:
  static constexpr double kTolerance = 0.01;

  int max_control_points() const override { return inner_->max_control_points(); }
  double time_tolerance() const override { return kTolerance; }
  std::unique_ptr<StageState> make_state() const override { return inner_->make_state(); }
  void prepare(const Step& step, StageState& state, Executor& executor) const override {
    inner_->prepare(step, state, executor);
  }
  void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block, std::vector<Contact>& contacts,
           NarrowCounters& counters) const override {
    const std::size_t before = contacts.size();
    inner_->run(step, state, worker, block, contacts, counters);
    for (std::size_t i = before; i < contacts.size(); ++i) {
      const auto& v = contacts[i].vertices;
      contacts[i].toi -= kTolerance * Random((std::uint64_t{v[0]} << 32 | v[1]) ^ v[3]).uniform();
    }
  }

 private:
  std::unique_ptr<NarrowPhase> inner_ = registry().stage<NarrowPhase>("inclusion").make({});
};

/// A contact may be reported before another one and occur after it. Once the other one is known, stages must not prove
/// by its time that the first one is irrelevant.
TEST(Pipelines, FirstIsTheEarliestReportedTime) {
  Registry with_early_times = Registry::standard();
  StageDescriptor<NarrowPhase> descriptor;
  descriptor.name = "early-times";
  descriptor.guarantee = Guarantee::conservative;
  descriptor.make = [](const OptionValues&) { return std::make_unique<EarlyTimes>(); };
  with_early_times.add(descriptor);
  const Scene scene = nearly_simultaneous(1500, EarlyTimes::kTolerance, 5);
  const Step step{scene.topology, scene.motion, kEverything};
  SerialExecutor serial;
  for (const char* name : {"VolCCD", "NavCCD"}) {
    PipelineSpec spec = registry().pipeline(name);
    spec.narrow_phase = {"early-times", {}};
    const Pipeline pipeline(with_early_times, spec);
    Workspace workspace = pipeline.make_workspace();
    StepResult all, first;
    pipeline.run(step, workspace, serial, all);
    pipeline.run(step, workspace, serial, first, {.query = Query::first});
    ASSERT_EQ(first.contacts.size(), 1u) << name;
    EXPECT_EQ(first.contacts.front().toi, all.statistics.earliest_toi) << name;
  }
}

TEST(Pipelines, SetRangeAndAdjacencyWhateverTheirCallerHasGiven) {
  const auto scenes = test::small_scenes(4, 0.3);
  const Scene& scene = scenes.front();
  const Mesh& mesh = scene.topology.mesh();
  Mesh same;  // as many elements, all of which are adjacent
  same.add_vertices(mesh.vertex_ids());
  for (Index o = 0; o < mesh.element_slots(); ++o)
    same.add_element({.type = ElementType::tetrahedron, .vertices = {0, 1, 2, 3}, .id = o});
  const Topology adjacent(std::move(same));
  SerialExecutor serial;
  for (const char* name : {"VolCCD", "NavCCD"}) {
    const Pipeline pipeline(registry(), registry().pipeline(name));
    Workspace workspace = pipeline.make_workspace();
    StepResult result;
    Step step{scene.topology, scene.motion, kEverything};
    step.range = std::string(name) == "VolCCD" ? PairRange::every : PairRange::nonadjacent;
    step.adjacency_table = &adjacent.adjacency();
    pipeline.run(step, workspace, serial, result);
    EXPECT_GT(result.contacts.size(), 0u) << name;
    EXPECT_EQ(result.contacts, run(registry().pipeline(name), scene).contacts) << name;
  }
}

TEST(Pipelines, PairScopesPartitionTheContacts) {
  for (const Scene& scene : test::small_scenes(4, 0.3))
    for (const PipelineSpec& spec : registry().pipelines()) {
      const StepResult all = run(spec, scene);
      const StepResult inter = run(spec, scene, Query::all, ObjectFilter(PairScope::inter));
      const StepResult intra = run(spec, scene, Query::all, ObjectFilter(PairScope::intra));
      const auto object = [&](Index v) {
        return scene.topology.mesh().object(scene.topology.features().vertex_elements(v).front());
      };
      for (const Contact& c : inter.contacts) EXPECT_NE(object(c.vertices[0]), object(c.vertices[3])) << spec.name;
      for (const Contact& c : intra.contacts) EXPECT_EQ(object(c.vertices[0]), object(c.vertices[3])) << spec.name;
      EXPECT_EQ(inter.contacts.size() + intra.contacts.size(), all.contacts.size()) << scene.name << " " << spec.name;
    }
}

/// Whether the rule allows the objects of some element at the first feature and of some element at the second: the
/// definition, applied to all elements that have the vertices.
bool asked_for(const Topology& topology, const Contact& contact, bool (*allowed)(int, int)) {
  const std::size_t first_size = contact.kind == FeatureKind::vf ? 1 : 2;
  const std::span<const Index> all(contact.vertices);
  const auto objects = [&](std::span<const Index> feature) {
    const auto elements = feature.size() == 1 ? topology.features().vertex_elements(feature[0])
                          : feature.size() == 2
                              ? topology.features().edge_elements(topology.features().find_edge(feature[0], feature[1]))
                              : topology.features().triangle_elements(
                                    topology.features().find_triangle(feature[0], feature[1], feature[2]));
    std::set<int> result;
    for (const Index o : elements) result.insert(topology.mesh().object(o));
    return result;
  };
  const std::set<int> first = objects(all.first(first_size)), second = objects(all.subspan(first_size));
  return std::any_of(first.begin(), first.end(), [&](int a) {
    return std::any_of(second.begin(), second.end(), [&](int b) { return allowed(a, b); });
  });
}

TEST(Pipelines, ScopesFollowTheirDefinitionWhereObjectsShareVertices) {
  // One block whose elements are distributed over three objects, so that features on the interfaces belong to several.
  Shape shape = block(ElementType::tetrahedron, 6, 2, 2);
  Random random(6);
  for (ElementSpec& element : shape.elements) {
    const auto third = static_cast<std::int32_t>(shape.positions[element.vertices[0]].x() / 2.1);
    element.object = 1 + (random.below(6) == 0 ? static_cast<std::int32_t>(random.below(3)) : third);
  }
  const Scene scene{"shared", Topology(shape.mesh()),
                    Motion::linear(shape.positions, jittered(shape.positions, 0.8, 5))};
  ObjectFilter excluding;
  excluding.exclude(1, 2);
  excluding.exclude(3, 3);
  ObjectFilter both(PairScope::inter);
  both.exclude(2, 3);
  const std::pair<ObjectFilter, bool (*)(int, int)> cases[] = {
      {ObjectFilter(PairScope::inter), [](int a, int b) { return a != b; }},
      {ObjectFilter(PairScope::intra), [](int a, int b) { return a == b; }},
      {excluding, [](int a, int b) { return !(a + b == 3) && !(a == 3 && b == 3); }},
      {both, [](int a, int b) { return a != b && a + b != 5; }}};
  for (const char* narrow : {"inclusion", "provot"}) {
    const StepResult all = run(reference(narrow), scene);
    for (const auto& [filter, allowed] : cases) {
      StepResult expected;
      for (const Contact& contact : all.contacts)
        if (asked_for(scene.topology, contact, allowed)) expected.contacts.push_back(contact);
      EXPECT_GT(expected.contacts.size(), 0u);
      EXPECT_LT(expected.contacts.size(), all.contacts.size());
      expect_same(expected, run(reference(narrow), scene, Query::all, filter), "without culling");
      for (const PipelineSpec& spec : registry().pipelines())
        if (spec.narrow_phase.name == narrow) expect_same(expected, run(spec, scene, Query::all, filter), spec.name);
    }
  }
}

/// Float bounds along the axes of the 16-DOP, computed without the library.
using Bounds = std::array<std::array<float, 2>, 8>;
Bounds naive_bounds(const Scene& scene, Index o) {
  constexpr int axes[8][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}, {1, -1, 0}, {1, 0, -1}};
  Bounds bounds;
  for (std::size_t k = 0; k < 8; ++k) {
    double low = INFINITY, high = -INFINITY;
    for (const Index v : scene.topology.mesh().vertices(o))
      for (int c = 0; c < 2; ++c) {
        const Vec3 p = scene.motion.point(v, c);
        const double s = axes[k][0] * p.x() + axes[k][1] * p.y() + axes[k][2] * p.z();
        low = std::min(low, s), high = std::max(high, s);
      }
    bounds[k] = {float_below(low), float_above(high)};
  }
  return bounds;
}

TEST(Pipelines, NavCcdPerformsTheTestsOfAllOverlappingPairs) {
  for (const Scene& scene : test::small_scenes(2, 0.1)) {
    const Mesh& mesh = scene.topology.mesh();
    const Features& features = scene.topology.features();
    std::vector<Bounds> bounds;
    for (Index o = 0; o < mesh.element_slots(); ++o) bounds.push_back(naive_bounds(scene, o));
    std::uint64_t pairs = 0, vf = 0, ee = 0;
    for (Index a = 0; a < mesh.element_slots(); ++a)
      for (Index b = a; b < mesh.element_slots(); ++b) {
        bool apart = false;
        for (std::size_t k = 0; k < 8; ++k)
          apart = apart || bounds[a][k][1] < bounds[b][k][0] || bounds[b][k][1] < bounds[a][k][0];
        if (apart) continue;
        ++pairs;
        std::set<std::pair<Index, Index>> vf_pairs, ee_pairs;
        for (const auto& [x, y] : {std::pair{a, b}, std::pair{b, a}}) {
          for (const Index v : mesh.vertices(x))
            for (const Index f : features.element_triangles(y)) {
              const auto& t = features.triangle(f);
              if (std::find(t.begin(), t.end(), v) == t.end()) vf_pairs.emplace(v, f);
            }
          for (const Index e : features.element_edges(x))
            for (const Index g : features.element_edges(y)) {
              const auto &p = features.edge(e), &q = features.edge(g);
              if (p[0] != q[0] && p[0] != q[1] && p[1] != q[0] && p[1] != q[1]) ee_pairs.insert(std::minmax(e, g));
            }
        }
        vf += vf_pairs.size(), ee += ee_pairs.size();
      }
    const Statistics s = run(registry().pipeline("NavCCD"), scene).statistics;
    EXPECT_EQ(s.element_pairs, pairs) << scene.name;
    EXPECT_EQ(s.vf_tests, vf) << scene.name;
    EXPECT_EQ(s.ee_tests, ee) << scene.name;
  }
}

TEST(Pipelines, WorkspaceFollowsTopologyChanges) {
  Shape shape = mixed_block(2, 2);
  Random random(17);
  for (const PipelineSpec& spec : registry().pipelines()) {
    Topology topology(shape.mesh());
    const Pipeline pipeline(registry(), spec);
    Workspace kept = pipeline.make_workspace();
    SerialExecutor serial;
    std::vector<ElementSpec> out;
    for (int round = 0; round < 6; ++round) {
      const Motion motion =
          Motion::linear(jittered(shape.positions, 0.3, random.next()), jittered(shape.positions, 0.3, random.next()));
      StepResult with_kept, with_fresh;
      pipeline.run({topology, motion, kEverything}, kept, serial, with_kept);
      Workspace fresh = pipeline.make_workspace();
      pipeline.run({topology, motion, kEverything}, fresh, serial, with_fresh);
      expect_same(with_fresh, with_kept, spec.name + " round " + std::to_string(round));
      EXPECT_EQ(with_fresh.statistics.tests(), with_kept.statistics.tests()) << spec.name;
      TopologyEdit edit;
      edit.added = std::move(out);
      out.clear();
      for (Index o = 0; o < topology.mesh().element_slots(); ++o)
        if (topology.mesh().is_live(o) && random.below(5) == 0) {
          edit.removed.push_back(o);
          for (const ElementSpec& element : shape.elements)
            if (element.id == topology.mesh().element_id(o)) out.push_back(element);
        }
      topology.apply(edit);
    }
  }
}

}  // namespace
}  // namespace volccd
