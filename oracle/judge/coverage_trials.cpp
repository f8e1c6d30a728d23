// Assignments and orphan sources, on small meshes that change.
#include <algorithm>
#include <iterator>

#include <volccd/broadphase/kdop_bvh.hpp>
#include <volccd/core/sort_unique.hpp>
#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/oracle/judge/detail/stage_trials.hpp>
#include <volccd/query/roles/assignment.hpp>
#include <volccd/query/roles/orphan_source.hpp>

namespace volccd::detail {

using cases::Choices;

namespace {

using Tests = std::vector<FeaturePair>;

/// Lists of tests, sorted and without duplicates.
struct Coverage {
  Tests vf, ee;

  const Tests& of(FeatureKind kind) const { return kind == FeatureKind::vf ? vf : ee; }
};

Coverage coverage_of(const TestBatch& batch) {
  Coverage coverage{batch.vf, batch.ee};
  sort_unique(coverage.vf);
  sort_unique(coverage.ee);
  return coverage;
}

Tests difference(const Tests& these, const Tests& those) {
  Tests left;
  std::set_difference(these.begin(), these.end(), those.begin(), those.end(), std::back_inserter(left));
  return left;
}

std::vector<ElementPair> element_pairs(const Topology& topology, PairRange range) {
  std::vector<ElementPair> pairs;
  const Mesh& mesh = topology.mesh();
  for (Index a = 0; a < mesh.element_slots(); ++a)
    for (Index b = a; b < mesh.element_slots(); ++b)
      if (mesh.is_live(a) && mesh.is_live(b) && (range == PairRange::every || !topology.adjacency().adjacent(a, b)))
        pairs.push_back({a, b});
  return pairs;
}

/// All feature pairs without a common vertex that some element pair covers.
Coverage covered_by(const Topology& topology, const std::vector<ElementPair>& pairs) {
  const Mesh& mesh = topology.mesh();
  const Features& f = topology.features();
  TestBatch all;
  const auto cover = [&](Index a, Index b) {
    for (const Index v : mesh.vertices(a))
      for (const Index t : f.element_triangles(b)) all.vf.push_back({v, t});
  };
  for (const ElementPair pair : pairs) {
    cover(pair.a, pair.b);
    cover(pair.b, pair.a);
    for (const Index e : f.element_edges(pair.a))
      for (const Index g : f.element_edges(pair.b)) all.ee.push_back({std::min(e, g), std::max(e, g)});
  }
  Coverage coverage = coverage_of(all);
  std::erase_if(coverage.vf, [&](FeaturePair pair) { return !is_test(f, FeatureKind::vf, pair); });
  std::erase_if(coverage.ee, [&](FeaturePair pair) { return pair.a == pair.b || !is_test(f, FeatureKind::ee, pair); });
  return coverage;
}

std::string text_of(const Features& f, FeatureKind kind, FeaturePair pair) {
  std::string text = kind == FeatureKind::vf ? "VF" : "EE";
  for (const Index v : test_vertices(f, kind, pair)) text += " " + std::to_string(v);
  return text;
}

/// A mesh that is made, then edited, and its motions.
class ChangingMesh {
 public:
  explicit ChangingMesh(Choices& choices)
      : choices_(choices), shape_(permuted(make_shape(choices), seed())), topology_(shape_.mesh()) {
    move();
  }

  Step step() const { return {topology_, motion_, everything_}; }

  /// Removes elements; the next call adds them again, with new ids.
  void edit() {
    TopologyEdit edit;
    const Mesh& mesh = topology_.mesh();
    std::int64_t next_id = 0;
    for (Index o = 0; o < mesh.element_slots(); ++o) {
      if (!mesh.is_live(o)) continue;
      next_id = std::max(next_id, mesh.element_id(o) + 1);
      if (gone_.empty() && choices_.below(4) == 0) edit.removed.push_back(o);
    }
    edit.added = std::move(gone_);
    gone_.clear();
    for (ElementSpec& spec : edit.added) spec.id = next_id++;
    for (const Index o : edit.removed) {
      const auto vertices = mesh.vertices(o), faces = mesh.polytope_faces(o);
      gone_.push_back({.type = mesh.type(o),
                       .vertices = {vertices.begin(), vertices.end()},
                       .faces = {faces.begin(), faces.end()},
                       .object = mesh.object(o)});
    }
    topology_.apply(edit);
    move();
  }

 private:
  std::uint64_t seed() { return static_cast<std::uint64_t>(choices_.below(1 << 30)); }

  static Shape make_shape(Choices& choices) {
    constexpr ElementType types[] = {ElementType::tetrahedron, ElementType::pyramid,  ElementType::wedge,
                                     ElementType::hexahedron,  ElementType::polytope, ElementType::quad};
    const int which = choices.below(8);
    return which < 6 ? block(types[which], 1 + choices.below(2), 1 + choices.below(2), 1) : mixed_block(1, 1);
  }

  /// Moves vertices so far that elements invert.
  void move() {
    motion_ = Motion::linear(jittered(shape_.positions, 0.6, seed()), jittered(shape_.positions, 0.6, seed()));
  }

  Choices& choices_;
  Shape shape_;
  Topology topology_;
  Motion motion_;
  ObjectFilter everything_;
  std::vector<ElementSpec> gone_;
};

void expect_tests(const Step& step, const TestBatch& batch, StageTrials& trials, const std::string& where) {
  const auto good = [&](FeatureKind kind, const Tests& tests) {
    return std::all_of(tests.begin(), tests.end(),
                       [&](FeaturePair pair) { return is_test(step.features(), kind, pair); });
  };
  trials.expect(kTests, good(FeatureKind::vf, batch.vf) && good(FeatureKind::ee, batch.ee),
                [&] { return where + "a test of features with a common vertex"; });
}

/// The tests of all pairs, in batches of a size.
TestBatch tests_of(const Assignment& stage, const Step& step, StageState& state, std::span<const ElementPair> pairs,
                   std::size_t size, unsigned workers) {
  TestBatch out;
  PairBatch batch;
  for (std::size_t begin = 0; begin < pairs.size(); begin += size) {
    batch.assign(pairs.subspan(begin, std::min(size, pairs.size() - begin)));
    stage.run(step, state, static_cast<unsigned>(begin / size) % workers, batch, out);
  }
  return out;
}

void try_range(const Assignment& stage, const Step& step, StageState& state, PairRange range, StageTrials& trials,
               const std::string& where) {
  std::vector<ElementPair> pairs = element_pairs(step.topology, range);
  const Coverage owed = covered_by(step.topology, pairs);
  TestBatch found = tests_of(stage, step, state, pairs, 64, 1);
  expect_tests(step, found, trials, where);
  const Coverage coverage = coverage_of(found);
  for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee}) {
    const Tests missing = difference(owed.of(kind), coverage.of(kind));
    trials.expect(
        kComplete, missing.empty(),
        [&] {
          return where + (range == PairRange::every ? "all pairs" : "non-adjacent pairs") + ": " +
                 std::to_string(missing.size()) + " are missing, " + text_of(step.features(), kind, missing[0]) +
                 " among them";
        },
        trials.conservative());
  }
  std::reverse(pairs.begin(), pairs.end());
  TestBatch again = tests_of(stage, step, state, pairs, 1, trials.threads->workers());
  for (Tests* tests : {&found.vf, &found.ee, &again.vf, &again.ee}) std::sort(tests->begin(), tests->end());
  trials.expect(kSameInEveryBatch, found.vf == again.vf && found.ee == again.ee,
                [&] { return where + "an element pair has different tests when it is alone, or with another worker"; });
}

/// The number of trials is 1/64 of that of other stages, because each trial has many more tests.
int coverage_trials(const StageTrials& trials) { return std::max(1, trials.config.trials / 64); }

}  // namespace

void try_stage(const Assignment& stage, StageTrials& trials) {
  const bool nonadjacent = stage.incomplete_on_nonadjacent().empty(), every = stage.incomplete_on_every().empty();
  trials.expect(kComplete, nonadjacent || every, [] {
    return "the stage declares neither that it covers non-adjacent pairs nor that it covers all pairs";
  });
  const auto kept = stage.make_state();
  trials.each_trial(coverage_trials(trials), [&](Choices& choices, const std::string& where) {
    ChangingMesh mesh(choices);
    for (int edits = 0; edits < 3; ++edits, mesh.edit()) {
      const Step step = mesh.step();
      const auto fresh = stage.make_state();
      stage.prepare(step, *kept, *trials.threads);
      stage.prepare(step, *fresh, *trials.threads);
      const std::string when = where + "after " + std::to_string(edits) + " edits, ";
      for (const PairRange range : {PairRange::nonadjacent, PairRange::every}) {
        if (range == PairRange::every ? !every : !nonadjacent) continue;
        try_range(stage, step, *kept, range, trials, when);
        try_range(stage, step, *fresh, range, trials, when + "new state, ");
      }
    }
  });
  Choices choices(trials.config.seed);
  ChangingMesh mesh(choices);
  const Step step = mesh.step();
  const std::vector<ElementPair> pairs =
      element_pairs(step.topology, nonadjacent ? PairRange::nonadjacent : PairRange::every);
  const auto state = stage.make_state();
  PairBatch batch;
  TestBatch out;
  trials.expect_no_allocation([&](int) {
    stage.prepare(step, *state, trials.serial);
    batch.assign(pairs);
    out.clear();
    stage.run(step, *state, 0, batch, out);
  });
}

namespace {

TestBatch orphans_of(const OrphanSource& stage, const Step& step, StageState& state, unsigned workers, bool backwards) {
  Work out;
  const std::size_t n = stage.blocks(state);
  for (std::size_t i = 0; i < n; ++i)
    stage.run(step, state, static_cast<unsigned>(i) % workers, backwards ? n - 1 - i : i, out);
  return out.tests;
}

/// Checks that the feature pairs which touch, and which no pair of non-adjacent elements covers, are found.
void expect_orphans(const Step& step, const TestBatch& found, StageTrials& trials, const std::string& where) {
  const Coverage all = covered_by(step.topology, element_pairs(step.topology, PairRange::every));
  const Coverage other = covered_by(step.topology, element_pairs(step.topology, PairRange::nonadjacent));
  const Coverage coverage = coverage_of(found);
  for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee})
    for (const FeaturePair pair : difference(difference(all.of(kind), other.of(kind)), coverage.of(kind))) {
      const cases::Case c = case_of(step, kind, pair);
      trials.expect(
          kComplete, !cases::touches(c, 1),
          [&] { return where + text_of(step.features(), kind, pair) + " touches and is missing:\n" + to_text(c); },
          trials.conservative());
    }
  trials.expect(
      kComplete, true, [] { return std::string(); }, trials.conservative());
}

/// Takes all rounds of a source of work after prepare(), repeatedly on one mesh.
template <class TakesStep>
void expect_no_allocation(const WorkSource& stage, StageState& state, StageTrials& trials, TakesStep&& takes_step) {
  Choices choices(trials.config.seed);
  ChangingMesh mesh(choices);
  const Step step = mesh.step();
  Work out;
  trials.expect_no_allocation([&](int) {
    stage.prepare(step, state, trials.serial);
    if (!takes_step(state)) return;
    out.pairs.clear();
    out.tests.clear();
    for (std::size_t number = 0;; ++number) {
      const Round round = stage.next_round(step, state, number, trials.serial);
      if (round.blocks == 0) return;
      for (std::size_t block = 0; block < round.blocks; ++block) stage.run(step, state, 0, block, out);
    }
  });
}

}  // namespace

void try_stage(const OrphanSource& stage, StageTrials& trials) {
  const auto kept = stage.make_state();
  trials.each_trial(coverage_trials(trials), [&](Choices& choices, const std::string& where) {
    ChangingMesh mesh(choices);
    for (int edits = 0; edits < 3; ++edits, mesh.edit()) {
      const Step step = mesh.step();
      const auto fresh = stage.make_state();
      stage.prepare(step, *kept, *trials.threads);
      stage.prepare(step, *fresh, trials.serial);
      const std::string when = where + "after " + std::to_string(edits) + " edits, ";
      TestBatch found = orphans_of(stage, step, *kept, 1, false);
      expect_tests(step, found, trials, when);
      expect_orphans(step, found, trials, when);
      expect_orphans(step, orphans_of(stage, step, *fresh, 1, false), trials, when + "new state, ");
      TestBatch again = orphans_of(stage, step, *kept, trials.threads->workers(), true);
      for (Tests* tests : {&found.vf, &found.ee, &again.vf, &again.ee}) std::sort(tests->begin(), tests->end());
      trials.expect(kSameInEveryBatch, found.vf == again.vf && found.ee == again.ee,
                    [&] { return when + "the tests differ in the reverse order of blocks, or with another worker"; });
    }
  });
  expect_no_allocation(stage, *stage.make_state(), trials, [](const StageState&) { return true; });
}

/// The pairs that a flood reaches depend on broad phase and culling, and are therefore checked in pipelines. Here, no
/// pair survives.
void try_stage(const Flood& stage, StageTrials& trials) {
  const KdopBvh broad_phase{KdopBvh::Config{}};
  expect_no_allocation(stage, *stage.make_state_with(broad_phase), trials,
                       [&](const StageState& state) { return stage.takes(state, false); });
}

}  // namespace volccd::detail
