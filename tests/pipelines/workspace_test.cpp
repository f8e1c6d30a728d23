// Data that a workspace may keep from step to step, and those that it must not: counts, caches of a topology, states of
// an interrupted step.
#include <fenv.h>

#include <set>
#include <thread>

#include <gtest/gtest.h>

#include <volccd/core/floating_point.hpp>
#include <volccd/pipelines/compare.hpp>
#include <volccd/pipelines/pipeline.hpp>

#include "pipelines/scenes.hpp"
#include "support/allocations.hpp"
#include "support/floating_point_environment.hpp"

namespace volccd {
namespace {

using test::registry;
using test::Scene;

void expect_same_contacts(const StepResult& expected, const StepResult& found, const std::string& what) {
  EXPECT_TRUE(compare_contacts(expected.contacts, found.contacts).empty()) << what;
}

/// All counts, without times and memory.
void expect_same_counts(const Statistics& expected, const Statistics& found, const std::string& what) {
  const auto counts = [](const Statistics& s) {
    std::vector<std::uint64_t> list = {
        s.steps,    s.element_pairs, s.adjacent_pairs, s.surviving_pairs,  s.owned_tests, s.orphan_tests, s.vf_tests,
        s.ee_tests, s.contacts,      s.duplicates,     s.initial_overlaps, s.degenerate,  s.undecided};
    for (const StageStatistics& stage : s.stages) list.insert(list.end(), {stage.in, stage.out});
    return list;
  };
  EXPECT_EQ(counts(expected), counts(found)) << what;
  EXPECT_EQ(expected.earliest_toi, found.earliest_toi) << what;
}

/// Removes a fifth of the elements and adds those that an earlier edit removed.
void edit(Topology& topology, const Shape& shape, Random& random, std::vector<ElementSpec>& out) {
  TopologyEdit change;
  change.added = std::move(out);
  out.clear();
  for (Index o = 0; o < topology.mesh().element_slots(); ++o)
    if (topology.mesh().is_live(o) && random.below(5) == 0) {
      change.removed.push_back(o);
      for (const ElementSpec& element : shape.elements)
        if (element.id == topology.mesh().element_id(o)) out.push_back(element);
    }
  topology.apply(change);
}

/// Unordered pairs of live elements that share a vertex, self pairs included.
std::uint64_t adjacent_pairs(const Mesh& mesh) {
  std::uint64_t pairs = 0;
  for (Index a = 0; a < mesh.element_slots(); ++a)
    for (Index b = a; b < mesh.element_slots(); ++b) {
      const auto v = mesh.vertices(a), w = mesh.vertices(b);
      pairs += std::find_first_of(v.begin(), v.end(), w.begin(), w.end()) != v.end() ? 1 : 0;
    }
  return pairs;
}

TEST(Workspace, OfNoneOrAnotherPipelineIsRefused) {
  const Scene scene = test::colliding("tetrahedra", block(ElementType::tetrahedron, 2, 2, 1), 3, 0.2);
  const ObjectFilter everything;
  const Step step{scene.topology, scene.motion, everything};
  SerialExecutor serial;
  StepResult result, expected;
  for (const PipelineSpec& spec : registry().pipelines()) {
    Pipeline pipeline(registry(), spec);
    const Pipeline twin(registry(), spec), other(registry(), registry().pipelines().front());
    const auto refused = [&](Workspace& workspace) {
      try {
        pipeline.run(step, workspace, serial, result);
        return false;
      } catch (const ConfigError& error) {
        return std::string(error.what()).find("make_workspace") != std::string::npos;
      }
    };
    Workspace none, of_twin = twin.make_workspace(), of_other = other.make_workspace();
    EXPECT_TRUE(refused(none)) << spec.name;
    EXPECT_TRUE(refused(of_twin)) << spec.name;
    EXPECT_TRUE(refused(of_other)) << spec.name;
    twin.run(step, of_twin, serial, expected);

    none = pipeline.make_workspace();
    pipeline.run(step, none, serial, result);
    expect_same_contacts(expected, result, spec.name);
    Workspace moved = std::move(none);
    EXPECT_TRUE(refused(none)) << spec.name;  // NOLINT: after a move it is as good as made by default
    const Pipeline moved_pipeline = std::move(pipeline);
    moved_pipeline.run(step, moved, serial, result);
    expect_same_contacts(expected, result, spec.name);
  }
}

// Every step is compared with the same step in a new workspace.
TEST(ThreadsWorkspace, CountsEachStepByItself) {
  Shape shape = mixed_block(1, 1);
  const std::size_t first_that_slides = shape.positions.size();
  shape.append(block(ElementType::hexahedron, 2, 1, 1).translate({5.3, 0, 0}), 1);
  std::vector<Vec3> slid = shape.positions;
  for (std::size_t v = first_that_slides; v < slid.size(); ++v) slid[v].x() -= 1;
  const std::vector<Motion> motions = {
      Motion::linear(shape.positions, slid),  // motions within the planes of faces give degenerate tests
      Motion::linear(jittered(shape.positions, 0.3, 1), jittered(shape.positions, 0.3, 2)),
      Motion::linear(jittered(shape.positions, 0.01, 3), jittered(shape.positions, 0.01, 4)),
      Motion::linear(shape.positions, jittered(shape.positions, 0.2, 5))};
  const auto three = make_thread_executor(3), two = make_thread_executor(2);
  SerialExecutor serial;
  Executor* const executors[] = {three.get(), &serial, two.get(), &serial};
  const char* const narrow_phases[] = {"inclusion", "cubic", "exact"};
  std::size_t turn = 0;  // every preset once, with the narrow phases in turn, and every narrow phase in VolCCD+
  std::vector<std::pair<PipelineSpec, const char*>> combinations;
  for (const PipelineSpec& spec : registry().pipelines()) combinations.emplace_back(spec, narrow_phases[turn++ % 3]);
  for (const char* narrow : narrow_phases) combinations.emplace_back(registry().pipeline("VolCCD+"), narrow);
  for (auto [spec, narrow] : combinations) {
    registry().apply_setting(spec, std::string("narrow-phase=") + narrow);
    const Pipeline pipeline(registry(), spec);
    Workspace kept = pipeline.make_workspace();
    Topology topology(shape.mesh());
    Random random(5);
    std::vector<ElementSpec> out;
    std::uint64_t max_degenerate = 0, min_degenerate = ~std::uint64_t{0};
    for (std::size_t i = 0; i < 12; ++i) {
      const ObjectFilter filter = i % 5 == 3 ? ObjectFilter(PairScope::intra) : ObjectFilter();
      const Step step{topology, motions[i % motions.size()], filter};
      const Request request{.query = i % 6 == 4 ? Query::first : Query::all, .initial_overlaps = i % 3 == 0};
      const std::string what = spec.name + " " + narrow + ", step " + std::to_string(i);
      StepResult with_kept, with_fresh;
      pipeline.run(step, kept, *executors[i % 4], with_kept, request);
      Workspace fresh = pipeline.make_workspace();
      pipeline.run(step, fresh, serial, with_fresh, request);
      expect_same_contacts(with_fresh, with_kept, what);
      EXPECT_TRUE(with_fresh.initial_overlaps == with_kept.initial_overlaps) << what;
      if (request.query == Query::all) expect_same_counts(with_fresh.statistics, with_kept.statistics, what);
      max_degenerate = std::max(max_degenerate, with_fresh.statistics.degenerate);
      min_degenerate = std::min(min_degenerate, with_fresh.statistics.degenerate);
      if (i % 3 == 2) edit(topology, shape, random, out);
    }
    EXPECT_TRUE(spec.narrow_phase.name != "cubic" || min_degenerate < max_degenerate) << "the scenes show nothing";
  }
}

TEST(Workspace, AdjacentPairsAreThoseOfTheMeshAsItIs) {
  const Shape shape = mixed_block(2, 1);
  const ObjectFilter everything;
  SerialExecutor serial;
  std::size_t counted = 0;
  for (const PipelineSpec& spec : registry().pipelines()) {
    const Pipeline pipeline(registry(), spec);
    Workspace kept = pipeline.make_workspace();
    Topology topology(shape.mesh());
    Random random(9);
    std::vector<ElementSpec> out;
    for (int step = 0; step < 5; ++step) {
      const Motion motion = Motion::linear(shape.positions, jittered(shape.positions, 0.2, random.next()));
      StepResult result;
      pipeline.run({topology, motion, everything}, kept, serial, result);
      if (result.statistics.adjacent_pairs != 0) {
        ++counted;
        EXPECT_EQ(result.statistics.adjacent_pairs, adjacent_pairs(topology.mesh())) << spec.name << " step " << step;
      }
      edit(topology, shape, random, out);
    }
  }
  EXPECT_GE(counted, 5u) << "no pipeline counts adjacent pairs";
}

/// Runs every chunk on a thread of its own, and calls `prepare` first on that thread.
class ForeignExecutor final : public Executor {
 public:
  explicit ForeignExecutor(void (*prepare)(std::size_t chunk)) : prepare_(prepare) {}
  unsigned workers() const override { return 1; }
  void parallel_for(std::size_t n, std::size_t grain, Body body) override {
    std::exception_ptr error;
    for (std::size_t begin = 0; begin < n && !error; begin += std::max<std::size_t>(grain, 1)) {
      std::jthread([&] {
        try {
          prepare_(chunk_++);
          body(begin, std::min(n, begin + std::max<std::size_t>(grain, 1)), 0);
        } catch (...) {
          error = std::current_exception();
        }
      });
    }
    if (error) std::rethrow_exception(error);
  }

 private:
  void (*prepare_)(std::size_t);
  std::size_t chunk_ = 0;
};

/// Allocations of the third of three rounds over the same motions; in the first two, all memory that is kept is
/// allocated.
std::size_t steady_allocations(const Pipeline& pipeline, const Shape& shape, Executor& executor) {
  const Topology topology(shape.mesh());
  const ObjectFilter no_filter;
  std::vector<Motion> motions;
  for (std::uint64_t seed = 0; seed < 4; ++seed)
    motions.push_back(Motion::linear(jittered(shape.positions, 0.1, seed), jittered(shape.positions, 0.3, seed + 10)));
  Workspace workspace = pipeline.make_workspace();
  StepResult result;
  std::size_t before = 0;
  for (int round = 0; round < 3; ++round) {
    if (round == 2) before = test::allocation_count();
    for (const Motion& motion : motions) pipeline.run({topology, motion, no_filter}, workspace, executor, result);
  }
  return test::allocation_count() - before;
}

/// The result has memory for the names of the stages in the statistics, whose size does not depend on the mesh.
TEST(Workspace, ASteadyStepAllocatesNothingButItsResult) {
  SerialExecutor serial;
  const Shape tiny = block(ElementType::tetrahedron, 1, 1, 1);
  for (const ElementType type : {ElementType::tetrahedron, ElementType::hexahedron})
    for (const char* name : {"NavCCD", "HashCCD", "VolCCD", "VolCCD+", "flood"}) {
      const bool flood = std::string(name) == "flood";
      PipelineSpec spec = registry().pipeline(flood ? "VolCCD+" : name);
      if (flood)
        spec.flood->options = {{"max_boundary_fraction", "1"},
                               {"max_divided_fraction", "1"},
                               {"max_suspect_fraction", "1"},
                               {"max_pairs", "1e9"}};
      const Pipeline pipeline(registry(), spec);
      EXPECT_EQ(steady_allocations(pipeline, block(type, 5, 5, 4), serial), steady_allocations(pipeline, tiny, serial))
          << name << ", " << to_string(type);
    }
}

TEST(FloatingPoint, OtherEnvironmentsAreRefused) {
  const Scene scene = test::colliding("tetrahedra", block(ElementType::tetrahedron, 2, 2, 1), 3, 0.2);
  const ObjectFilter everything;
  const Step step{scene.topology, scene.motion, everything};
  SerialExecutor serial;
  for (const PipelineSpec& spec : registry().pipelines()) {
    const Pipeline pipeline(registry(), spec);
    Workspace workspace = pipeline.make_workspace();
    StepResult result;
    for (const auto& [change, problem] : test::environments()) {
      std::string message = "no error";
      {
        const test::ChangedEnvironment changed(change);
        try {
          pipeline.run(step, workspace, serial, result);
        } catch (const ConfigError& error) {
          message = error.what();
        }
      }
      EXPECT_NE(message.find(problem), std::string::npos) << spec.name << ": " << message;
      EXPECT_NE(message.find("fesetenv"), std::string::npos) << "what to do: " << message;
    }
    // An allocation fails at a worker, at first and later in the step; afterwards the workspace works again.
    StepResult expected;
    Workspace fresh = pipeline.make_workspace();
    pipeline.run(step, fresh, serial, expected);
    ForeignExecutor standard([](std::size_t) {}), down([](std::size_t) { fesetround(FE_DOWNWARD); }),
        later([](std::size_t chunk) { fesetround(chunk == 3 ? FE_UPWARD : FE_TONEAREST); });
    for (Executor* executor : {&down, &later}) {
      EXPECT_THROW(pipeline.run(step, workspace, *executor, result), ConfigError) << spec.name;
      pipeline.run(step, workspace, standard, result);
      expect_same_contacts(expected, result, spec.name);
    }
  }
}

// An allocation of a run fails after a change of the topology; the same run is then repeated, and must be right.
TEST(Workspace, ServesAgainAfterARunOutOfMemory) {
  const Shape shape = mixed_block(1, 1);
  const ObjectFilter everything;
  SerialExecutor serial;
  for (const PipelineSpec& spec : registry().pipelines()) {
    const Pipeline pipeline(registry(), spec);
    Workspace kept = pipeline.make_workspace();
    Topology topology(shape.mesh());
    Random random(11);
    std::vector<ElementSpec> out;
    std::size_t failures = 0;
    bool failed = true;
    for (std::size_t n = 1; failed; n += 1 + n / 4) {
      const Motion motion = Motion::linear(jittered(shape.positions, 0.3, n), jittered(shape.positions, 0.3, n + 1));
      const Step step{topology, motion, everything};
      StepResult with_kept, with_fresh;
      failed = false;
      {
        const test::FailingAllocation failing(n);
        try {
          pipeline.run(step, kept, serial, with_kept);
        } catch (const std::bad_alloc&) {
          failed = true;
        }
      }
      failures += failed ? 1 : 0;
      pipeline.run(step, kept, serial, with_kept);
      Workspace fresh = pipeline.make_workspace();
      pipeline.run(step, fresh, serial, with_fresh);
      expect_same_contacts(with_fresh, with_kept, spec.name + ", allocation " + std::to_string(n));
      expect_same_counts(with_fresh.statistics, with_kept.statistics, spec.name + ", allocation " + std::to_string(n));
      edit(topology, shape, random, out);
    }
    EXPECT_GT(failures, 5u) << spec.name;
  }
}

}  // namespace
}  // namespace volccd
