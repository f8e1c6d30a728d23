// What a pipeline promises its stages (query/stage.hpp, query/work_source.hpp), seen by a stage in each role that keeps
// all that it may in prepare() and compares what run() gets.
#include <algorithm>
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <volccd/core/random.hpp>
#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/pipelines/pipeline.hpp>

#include "support/all_stages.hpp"

namespace volccd {
namespace {

/// The calls of all watched stages in one run.
struct Calls {
  std::atomic<int> runs{0}, rounds{0}, survivors{0};
};

/// The state of the stage itself, and the step of its last prepare().
struct WatchedState final : StageState {
  std::unique_ptr<StageState> inner;
  std::optional<Step> step;
  std::uint64_t version = 0;
  std::vector<Vec3> positions;  ///< of the first control point
  int prepares = 0;             ///< since the last check_counts()
  std::size_t next_round = 0;
  bool selects = false;  ///< select() of a filter was prepared for the step
};

WatchedState& own(StageState& state) { return static_cast<WatchedState&>(state); }
const WatchedState& own(const StageState& state) { return static_cast<const WatchedState&>(state); }

std::vector<Vec3> positions_of(const Motion& motion) {
  std::vector<Vec3> all;
  for (Index v = 0; v < motion.vertex_count(); ++v) all.push_back(motion.point(v, 0));
  return all;
}

void watch_prepare(const Step& step, WatchedState& state) {
  state.step.emplace(step);
  state.version = step.topology.version();
  state.positions = positions_of(step.motion);
  state.next_round = 0;
  state.selects = false;
  ++state.prepares;
}

void expect_step_of_prepare(const Step& step, const StageState& stage_state, const char* role) {
  const WatchedState& state = own(stage_state);
  ASSERT_TRUE(state.step) << role << ": run() without prepare()";
  EXPECT_EQ(&step.topology, &state.step->topology) << role;
  EXPECT_EQ(&step.motion, &state.step->motion) << role;
  EXPECT_EQ(&step.filter, &state.step->filter) << role;
  EXPECT_EQ(step.separation, state.step->separation) << role;
  EXPECT_EQ(step.range, state.step->range) << role;
  EXPECT_EQ(step.adjacency_table, state.step->adjacency_table) << role;
  EXPECT_LE(step.t_max, state.step->t_max) << role;
  EXPECT_EQ(step.topology.version(), state.version) << role;
  EXPECT_EQ(step.motion.point(0, 0), state.positions[0]) << role;
}

/// States of all watched stages, to be looked at after a run. A pipeline keeps them in its workspace.
using States = std::vector<std::pair<std::string, WatchedState*>>;

template <class Role>
struct Inner {
  std::unique_ptr<Role> stage;
  std::shared_ptr<Calls> calls;
  std::shared_ptr<States> states;

  std::unique_ptr<StageState> wrap(std::unique_ptr<StageState> inner) const {
    auto state = std::make_unique<WatchedState>();
    state->inner = std::move(inner);
    states->emplace_back(Role::kRole, state.get());
    return state;
  }
  void prepare(const Step& step, StageState& state, Executor& executor) const {
    watch_prepare(step, own(state));
    stage->prepare(step, *own(state).inner, executor);
  }
  StageState& state_for_run(const Step& step, StageState& state) const {
    expect_step_of_prepare(step, state, Role::kRole);
    ++calls->runs;
    return *own(state).inner;
  }
};

template <class Role>
class Watched;

template <>
class Watched<ElementCulling> final : public ElementCulling {
 public:
  explicit Watched(Inner<ElementCulling> inner) : inner_(std::move(inner)) {}
  std::unique_ptr<StageState> make_state() const override { return inner_.wrap(inner_.stage->make_state()); }
  void prepare(const Step& step, StageState& state, Executor& executor) const override {
    inner_.prepare(step, state, executor);
  }
  void run(const Step& step, StageState& state, unsigned worker, PairBatch& batch) const override {
    inner_.stage->run(step, inner_.state_for_run(step, state), worker, batch);
  }

 private:
  Inner<ElementCulling> inner_;
};

template <>
class Watched<Assignment> final : public Assignment {
 public:
  explicit Watched(Inner<Assignment> inner) : inner_(std::move(inner)) {}
  std::string incomplete_on_nonadjacent() const override { return inner_.stage->incomplete_on_nonadjacent(); }
  std::string incomplete_on_every() const override { return inner_.stage->incomplete_on_every(); }
  std::unique_ptr<StageState> make_state() const override { return inner_.wrap(inner_.stage->make_state()); }
  void prepare(const Step& step, StageState& state, Executor& executor) const override {
    inner_.prepare(step, state, executor);
  }
  void run(const Step& step, StageState& state, unsigned worker, const PairBatch& batch,
           TestBatch& out) const override {
    inner_.stage->run(step, inner_.state_for_run(step, state), worker, batch, out);
  }

 private:
  Inner<Assignment> inner_;
};

template <>
class Watched<BroadPhase> final : public BroadPhase {
 public:
  explicit Watched(Inner<BroadPhase> inner) : inner_(std::move(inner)) {}
  std::unique_ptr<StageState> make_state() const override { return inner_.wrap(inner_.stage->make_state()); }
  void prepare(const Step& step, StageState& state, Executor& executor) const override {
    inner_.prepare(step, state, executor);
  }
  std::size_t blocks(const Step& step, StageState& state, Executor& executor) const override {
    EXPECT_EQ(own(state).next_round++, 0u) << "blocks() is called once for a step";
    return inner_.stage->blocks(step, inner_.state_for_run(step, state), executor);
  }
  void run(const Step& step, StageState& state, unsigned worker, std::size_t block, Work& work) const override {
    inner_.stage->run(step, inner_.state_for_run(step, state), worker, block, work);
  }

 private:
  Inner<BroadPhase> inner_;
};

template <>
class Watched<OrphanSource> final : public OrphanSource {
 public:
  explicit Watched(Inner<OrphanSource> inner) : inner_(std::move(inner)) {}
  std::unique_ptr<StageState> make_state() const override { return inner_.wrap(inner_.stage->make_state()); }
  void prepare(const Step& step, StageState& state, Executor& executor) const override {
    inner_.prepare(step, state, executor);
  }
  std::size_t blocks(const StageState& state) const override { return inner_.stage->blocks(*own(state).inner); }
  void run(const Step& step, StageState& state, unsigned worker, std::size_t block, Work& work) const override {
    inner_.stage->run(step, inner_.state_for_run(step, state), worker, block, work);
  }

 private:
  Inner<OrphanSource> inner_;
};

template <>
class Watched<Flood> final : public Flood {
 public:
  explicit Watched(Inner<Flood> inner) : inner_(std::move(inner)) {}
  std::unique_ptr<StageState> make_state_with(const BroadPhase& broad_phase) const override {
    return inner_.wrap(inner_.stage->make_state_with(broad_phase));
  }
  void prepare(const Step& step, StageState& state, Executor& executor) const override {
    inner_.prepare(step, state, executor);
  }
  bool takes(const StageState& state, bool overlaps) const override {
    return inner_.stage->takes(*own(state).inner, overlaps);
  }
  const Step& step(const StageState& state) const override { return inner_.stage->step(*own(state).inner); }
  Round next_round(const Step& step, StageState& state, std::size_t number, Executor& executor) const override {
    EXPECT_EQ(number, own(state).next_round++) << "rounds come in order";
    ++inner_.calls->rounds;
    return inner_.stage->next_round(step, inner_.state_for_run(step, state), number, executor);
  }
  void run(const Step& step, StageState& state, unsigned worker, std::size_t block, Work& work) const override {
    inner_.stage->run(step, inner_.state_for_run(step, state), worker, block, work);
  }
  void record_survivors(StageState& state, unsigned worker, std::span<const ElementPair> pairs) const override {
    ++inner_.calls->survivors;
    inner_.stage->record_survivors(*own(state).inner, worker, pairs);
  }
  void to_mesh_features(const StageState& state, TestBatch& tests, std::size_t vf, std::size_t ee) const override {
    inner_.stage->to_mesh_features(*own(state).inner, tests, vf, ee);
  }

 private:
  Inner<Flood> inner_;
};

template <>
class Watched<FeatureFilter> final : public FeatureFilter {
 public:
  explicit Watched(Inner<FeatureFilter> inner) : inner_(std::move(inner)) {}
  std::unique_ptr<StageState> make_state() const override { return inner_.wrap(inner_.stage->make_state()); }
  void prepare(const Step& step, StageState& state, Executor& executor) const override {
    inner_.prepare(step, state, executor);
  }
  void prepare_select(const Step& step, StageState& state, Executor& executor) const override {
    EXPECT_FALSE(std::exchange(own(state).selects, true)) << "select() is prepared once, after prepare()";
    inner_.stage->prepare_select(step, *own(state).inner, executor);
  }
  std::size_t select(const Step& step, StageState& state, unsigned worker, FeatureKind kind,
                     std::span<FeaturePair> tests) const override {
    EXPECT_TRUE(own(state).selects);
    return inner_.stage->select(step, inner_.state_for_run(step, state), worker, kind, tests);
  }
  void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block,
           std::span<std::uint8_t> keep) const override {
    inner_.stage->run(step, inner_.state_for_run(step, state), worker, block, keep);
  }

 private:
  Inner<FeatureFilter> inner_;
};

template <>
class Watched<NarrowPhase> final : public NarrowPhase {
 public:
  explicit Watched(Inner<NarrowPhase> inner) : inner_(std::move(inner)) {}
  int max_control_points() const override { return inner_.stage->max_control_points(); }
  bool handles_separation() const override { return inner_.stage->handles_separation(); }
  double time_tolerance() const override { return inner_.stage->time_tolerance(); }
  std::unique_ptr<StageState> make_state() const override { return inner_.wrap(inner_.stage->make_state()); }
  void prepare(const Step& step, StageState& state, Executor& executor) const override {
    inner_.prepare(step, state, executor);
  }
  void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block, std::vector<Contact>& contacts,
           NarrowCounters& counters) const override {
    EXPECT_EQ(step.t_max, own(state).step->t_max) << "a narrow phase receives the step unchanged";
    inner_.stage->run(step, inner_.state_for_run(step, state), worker, block, contacts, counters);
  }

 private:
  Inner<NarrowPhase> inner_;
};

/// The registry of the program, with each stage watched.
class WatchedRegistry {
 public:
  WatchedRegistry() {
    const Registry plain = test::all_stages();
    add<BroadPhase>(plain), add<ElementCulling>(plain), add<Assignment>(plain), add<OrphanSource>(plain);
    add<Flood>(plain), add<FeatureFilter>(plain), add<NarrowPhase>(plain);
    for (const PipelineSpec& spec : plain.pipelines()) registry_.add_pipeline(spec);
  }

  const Registry& registry() const { return registry_; }
  Calls& calls() const { return *calls_; }

  /// In one step each stage is prepared once at most. Begins to count anew.
  void expect_one_prepare(const std::string& what) const {
    for (const auto& [role, state] : *states_) EXPECT_LE(std::exchange(state->prepares, 0), 1) << what << ": " << role;
  }
  /// Given tests are too few for a table for select(). Begins to count anew.
  void expect_no_selection(const std::string& what) const {
    for (const auto& [role, state] : *states_) {
      EXPECT_FALSE(state->selects) << what << ": " << role;
      state->prepares = 0;
    }
  }
  void forget_states() const { states_->clear(); }

 private:
  template <class Role>
  void add(const Registry& plain) {
    for (StageDescriptor<Role> stage : plain.stages<Role>()) {
      stage.make = [make = stage.make, calls = calls_, states = states_](const OptionValues& options) {
        return std::make_unique<Watched<Role>>(Inner<Role>{make(options), calls, states});
      };
      registry_.add(std::move(stage));
    }
  }

  std::shared_ptr<Calls> calls_ = std::make_shared<Calls>();
  std::shared_ptr<States> states_ = std::make_shared<States>();
  Registry registry_;
};

/// All presets, VolCCD+ with floods that take every step, and with floods that pair everything.
std::vector<PipelineSpec> watched_pipelines(const Registry& registry) {
  std::vector<PipelineSpec> specs(registry.pipelines().begin(), registry.pipelines().end());
  for (const char* max_pairs : {"1e9", "0"}) {
    PipelineSpec flood = registry.pipeline("VolCCD+");
    flood.name = std::string("flood, max_pairs ") + max_pairs;
    flood.flood->options = {{"max_boundary_fraction", "1"},
                            {"max_divided_fraction", "1"},
                            {"max_suspect_fraction", "1"},
                            {"max_pairs", max_pairs}};
    specs.push_back(flood);
  }
  return specs;
}

/// Ignores what it receives.
class Silent final : public StageObserver {
 public:
  void observe(std::size_t, unsigned, const Step&, std::span<const ElementPair>,
               std::span<const std::uint8_t>) override {}
  void observe(std::size_t, unsigned, const Step&, FeatureKind, std::span<const FeaturePair>,
               std::span<const std::uint8_t>) override {}
};

Request with(Query query, bool overlaps, StageObserver* observer) {
  Request request;
  request.query = query;
  request.initial_overlaps = overlaps;
  request.observer = observer;
  return request;
}

void expect_features(const Topology& topology, const std::vector<Contact>& contacts) {
  const Features& features = topology.features();
  for (const Contact& c : contacts) {
    const bool vf = c.kind == FeatureKind::vf;
    const auto [a, b] = c.features;
    EXPECT_EQ(test_vertices(features, c.kind, vf ? c.features : FeaturePair{std::min(a, b), std::max(a, b)}),
              c.vertices);
    if (!vf) {
      EXPECT_EQ(features.edge(a)[0], c.vertices[0]);
    }
    const std::span<const Index> of[2] = {vf ? features.vertex_elements(a) : features.edge_elements(a),
                                          vf ? features.triangle_elements(b) : features.edge_elements(b)};
    for (std::size_t side = 0; side < 2; ++side) {
      EXPECT_TRUE(std::ranges::count(of[side], c.elements[side]) == 1);
      for (const Index o : of[side])
        EXPECT_LE(topology.mesh().element_id(c.elements[side]), topology.mesh().element_id(o));
    }
  }
}

/// Two bodies that go through each other, steps after edits, and steps of another topology in the same workspace.
TEST(StageContract, EachStageRunsOnTheStepOfItsOnlyPrepare) {
  const WatchedRegistry watched;
  const auto executor = make_thread_executor(2);
  for (const PipelineSpec& spec : watched_pipelines(watched.registry())) {
    const Pipeline pipeline(watched.registry(), spec);
    watched.forget_states();
    Workspace workspace = pipeline.make_workspace();
    Random random(7);
    std::size_t contacts = 0;
    for (const ElementType type : {ElementType::tetrahedron, ElementType::hexahedron}) {
      Shape shape = block(type, 3, 3, 3);
      Shape other = block(type, 2, 2, 2);
      for (Vec3& p : other.positions) p += Vec3(0.53, 0.47, 2.9);
      shape.append(other, 1);
      Topology topology(shape.mesh());
      for (int step = 0; step < 4; ++step) {
        const std::vector<Vec3> x0 = jittered(shape.positions, 0.05, random.next());
        std::vector<Vec3> x1 = jittered(shape.positions, 0.05, random.next());
        for (Vec3& p : x1)
          if (p.z() > 2.8) p.z() -= 0.4;
        const Motion motion = Motion::linear(x0, x1);
        const ObjectFilter filter = step == 2 ? ObjectFilter(PairScope::inter) : ObjectFilter();
        Silent observer;
        const Request requests[] = {Request{}, with(Query::first, false, nullptr), with(Query::all, true, &observer)};
        std::vector<Contact> plain;
        for (const Request& request : requests) {
          StepResult result;
          const std::string what = spec.name + ", " + to_string(type) + ", step " + std::to_string(step);
          pipeline.run({topology, motion, filter}, workspace, *executor, result, request);
          watched.expect_one_prepare(what);
          expect_features(topology, result.contacts);
          if (&request == requests) plain = result.contacts;
          if (request.observer) {
            EXPECT_EQ(result.contacts, plain) << what << ": an observer changes the result";
          }
          contacts += result.contacts.size();
        }
        TestBatch list;
        StepResult result;
        pipeline.run({topology, motion, filter}, workspace, *executor, result, {.candidates = &list});
        pipeline.run({topology, motion, filter}, workspace, *executor, result, {.tests = &list});
        EXPECT_EQ(result.contacts, plain) << spec.name;
        watched.expect_no_selection(spec.name);
        topology.apply({{static_cast<Index>(3 * step)}, {}, {}});
      }
    }
    EXPECT_GT(contacts, 100u) << spec.name;
  }
  EXPECT_GT(watched.calls().runs, 1000);
  EXPECT_GT(watched.calls().rounds, 30);
  EXPECT_GT(watched.calls().survivors, 30);
}

}  // namespace
}  // namespace volccd
