// Element culling and broad phases, on generated pairs of elements.
#include <algorithm>
#include <map>
#include <mutex>

#include <volccd/broadphase/candidate_pairs.hpp>
#include <volccd/core/random.hpp>
#include <volccd/oracle/cases/element_pairs.hpp>
#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/oracle/judge/detail/stage_trials.hpp>

namespace volccd::detail {

using cases::Case;
using cases::Choices;
using cases::ElementPairs;

namespace {

constexpr Index kPairs = 8;

/// Pairs of one step.
struct PairGroup {
  StepChoice choice;
  double separation, t_max;
  std::vector<Case> cases;
  std::vector<bool> nested;  ///< one of the elements lies in the other at the start
};

PairGroup make_group(Choices& choices, ElementPairs& elements) {
  PairGroup group{choose_step(choices), 0, 1, {}, {}};
  const auto attacks = group.choice.separation ? cases::separation_attacks() : cases::touching_attacks();
  const auto nearly =
      cases::nearly_degenerate_elements(group.choice.separation ? cases::Separation::some : cases::Separation::none);
  for (Index i = 0; i < elements.size(); ++i) {
    const int which = choices.below(8);
    const bool nested = which == 7;
    Case c = elements.choose(choices, i, group.choice.kind, group.choice.control_points,
                             nested      ? cases::nested_elements
                             : which < 4 ? nearly
                                         : cases::attacking_elements(attacks));
    if (i == 0) group.separation = c.separation;
    if (c.separation != group.separation) c.separation = group.separation, c.touch = -1;
    group.cases.push_back(std::move(c));
    group.nested.push_back(nested);
  }
  group.t_max = choose_t_max(choices, group.cases.front());
  return group;
}

std::vector<Vec3> start(const Step& step, Index element) {
  std::vector<Vec3> points;
  for (const Index v : step.mesh().vertices(element)) points.push_back(step.motion.point(v, 0));
  return points;
}

bool overlap_at_start(const Step& step, ElementPair pair) {
  return exact_hulls_overlap(start(step, pair.a), start(step, pair.b));
}

std::string text_of(const Step& step, const Case& c) {
  return "with t_max " + std::to_string(step.t_max) + "; the features, and the vertices around them:\n" + to_text(c);
}

/// Scenes that the trials use in turn, so that a state is used with more than one topology.
std::vector<std::unique_ptr<ElementPairs>> all_elements() {
  std::vector<std::unique_ptr<ElementPairs>> all;
  for (const ElementType type : {ElementType::tetrahedron, ElementType::hexahedron, ElementType::tetrahedron,
                                 ElementType::wedge, ElementType::pyramid})
    all.push_back(std::make_unique<ElementPairs>(type, kPairs));
  return all;
}

/// The verdict of element culling on a pair.
struct Verdict {
  bool dropped = true, contact_free = false;
  FeatureMask mask{};

  bool operator==(const Verdict& other) const {
    return dropped == other.dropped && contact_free == other.contact_free &&
           (dropped || (mask.vertices_a == other.mask.vertices_a && mask.vertices_b == other.mask.vertices_b &&
                        mask.edges_a == other.mask.edges_a && mask.edges_b == other.mask.edges_b));
  }
};

class CullingTrials {
 public:
  CullingTrials(const ElementCulling& stage, StageTrials& trials)
      : stage_(stage), trials_(trials), kept_(stage.make_state()) {}

  void run(const ElementPairs& elements, const PairGroup& group, const std::string& where) {
    const Step step = elements.step(group.choice.control_points, group.separation, group.t_max);
    std::vector<ElementPair> pairs;
    for (Index i = 0; i < elements.size(); ++i) pairs.push_back(elements.pair(i));
    stage_.prepare(step, *kept_, *trials_.threads);
    const std::vector<Verdict> together = verdicts(step, *kept_, pairs, 0, where);
    compare_batches(step, pairs, together, group, where);
    const auto fresh = stage_.make_state();
    stage_.prepare(step, *fresh, trials_.serial);
    const std::vector<Verdict> anew = verdicts(step, *fresh, pairs, 0, where);
    for (Index i = 0; i < elements.size(); ++i) {
      judge(elements, step, group, i, together[i], where);
      if (!(anew[i] == together[i])) judge(elements, step, group, i, anew[i], where + "(new state) ");
    }
  }

 private:
  std::vector<Verdict> verdicts(const Step& step, StageState& state, std::span<const ElementPair> pairs,
                                unsigned worker, const std::string& where) {
    batch_.assign(pairs);
    stage_.run(step, state, worker, batch_);
    std::vector<Verdict> verdicts(pairs.size());
    std::size_t next = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      verdicts[i].contact_free =
          std::find(batch_.contact_free.begin(), batch_.contact_free.end(), pairs[i]) != batch_.contact_free.end();
      if (next == batch_.pairs.size() || batch_.pairs[next] != pairs[i]) continue;
      verdicts[i].dropped = false;
      verdicts[i].mask = batch_.masks[next++];
    }
    trials_.expect(kOnlyDrops, next == batch_.pairs.size() && batch_.masks.size() == batch_.pairs.size(), [&] {
      return where +
             "the batch has pairs that it did not have, has them in another order, or has another number of masks";
    });
    return verdicts;
  }

  void compare_batches(const Step& step, std::vector<ElementPair> pairs, const std::vector<Verdict>& together,
                       const PairGroup& group, const std::string& where) {
    const unsigned workers = trials_.threads->workers();
    std::vector<Verdict> alone;
    for (std::size_t i = 0; i < pairs.size(); ++i)
      alone.push_back(verdicts(step, *kept_, {&pairs[i], 1}, static_cast<unsigned>(i) % workers, where)[0]);
    std::reverse(pairs.begin(), pairs.end());
    std::vector<Verdict> backwards = verdicts(step, *kept_, pairs, workers - 1, where);
    std::reverse(backwards.begin(), backwards.end());
    for (std::size_t i = 0; i < pairs.size(); ++i)
      trials_.expect(kSameInEveryBatch, alone[i] == together[i] && backwards[i] == together[i], [&] {
        return where + "pair " + std::to_string(i) +
               " has a different answer when it is alone, or in reverse order with another worker, " +
               text_of(step, group.cases[i]);
      });
  }

  void judge(const ElementPairs& elements, const Step& step, const PairGroup& group, Index i, const Verdict& verdict,
             const std::string& where) {
    const Case& c = group.cases[i];
    const bool lost = verdict.dropped || elements.masked(i, verdict.mask);
    trials_.expect(
        kLosesNoContact, !lost || !cases::touches(c, group.t_max),
        [&] { return where + (verdict.dropped ? "drops " : "masks ") + text_of(step, c); }, trials_.conservative());
    if (!verdict.dropped || verdict.contact_free) return;
    trials_.expect(
        kOverlapsStay, !overlap_at_start(step, elements.pair(i)),
        [&] { return where + "drops as disjoint " + text_of(step, c); }, trials_.conservative());
  }

  const ElementCulling& stage_;
  StageTrials& trials_;
  std::unique_ptr<StageState> kept_;
  PairBatch batch_;
};

class BroadTrials {
 public:
  BroadTrials(const BroadPhase& stage, StageTrials& trials)
      : stage_(stage), trials_(trials), serial_(stage.make_state()), threaded_(stage.make_state()) {}

  void run(const ElementPairs& elements, const PairGroup& group, const std::string& where) {
    const Step step = elements.step(group.choice.control_points, group.separation, group.t_max);
    const auto pairs = emitted(step, *serial_, trials_.serial, where);
    const auto by_threads = emitted(step, *threaded_, *trials_.threads, where);
    const auto fresh = stage_.make_state();
    const auto anew = emitted(step, *fresh, trials_.serial, where);
    trials_.expect(kSameInEveryBatch, pairs == by_threads,
                   [&] { return where + "several workers emit pairs that differ from those of one worker"; });
    trials_.expect(kSameAfterOtherSteps, pairs == anew, [&] { return where + "a new state emits different pairs"; });
    for (Index i = 0; i < elements.size(); ++i) {
      const bool found = pairs.contains(elements.pair(i));
      const Case& c = group.cases[i];
      trials_.expect(
          kEmitsAll,
          found || !(cases::touches(c, group.t_max) || (group.nested[i] && overlap_at_start(step, elements.pair(i)))),
          [&] { return where + "does not emit " + text_of(step, c); }, trials_.conservative());
    }
  }

 private:
  /// Each pair, and how often it was emitted.
  std::map<ElementPair, int> emitted(Step step, StageState& state, Executor& executor, const std::string& where) {
    std::map<ElementPair, int> pairs;
    std::mutex mutex;
    bool regular = true;
    step.range = PairRange::nonadjacent;
    stage_.prepare(step, state, executor);
    visit_candidates(stage_, step, state, executor, [&](std::span<const ElementPair> block, unsigned) {
      const std::lock_guard lock(mutex);
      for (const ElementPair pair : block) regular = regular && pair.a <= pair.b && ++pairs[pair] == 1;
    });
    trials_.expect(kEmitsOnce, regular, [&] { return where + "a pair is repeated, or is (b, a) instead of (a, b)"; });
    return pairs;
  }

  const BroadPhase& stage_;
  StageTrials& trials_;
  std::unique_ptr<StageState> serial_, threaded_;
};

template <class Trials, class Kind>
void try_pairs(const Kind& stage, StageTrials& trials) {
  const auto elements = all_elements();
  const std::unique_ptr<ElementPairs> single[] = {std::make_unique<ElementPairs>(ElementType::tetrahedron),
                                                  std::make_unique<ElementPairs>(ElementType::hexahedron)};
  Trials pairs(stage, trials);
  trials.each_trial(trials.config.trials, [&](Choices& choices, const std::string& where) {
    ElementPairs& scene = *elements[static_cast<std::size_t>(choices.below(static_cast<int>(elements.size())))];
    pairs.run(scene, make_group(choices, scene), where);
    // In a group, only the first pair lies exactly at its separation.
    for (int i = 0; i < 4; ++i) {
      ElementPairs& one = *single[static_cast<std::size_t>(choices.below(2))];
      pairs.run(one, make_group(choices, one), where);
    }
  });
}

/// Ordinary motions of a block of tetrahedra: the first half of the steps have different ones, and the second half have
/// the same again, because the memory that a stage needs may depend on the motion.
template <class Run>
void count_allocations(const Stage& stage, StageTrials& trials, Run&& run) {
  const Shape shape = block(ElementType::tetrahedron, 3, 3, 3);
  const Topology topology(shape.mesh());
  const ObjectFilter everything;
  const auto state = stage.make_state();
  Motion motion;
  std::vector<Motion> motions;
  for (std::uint64_t k = 0; k < StageTrials::kWarmUp; ++k)
    motions.push_back(Motion::linear(jittered(shape.positions, 0.3, trials.config.seed + k),
                                     jittered(shape.positions, 0.3, trials.config.seed + k + 1)));
  trials.expect_no_allocation([&](int k) {
    const Step step{topology, motions[static_cast<std::size_t>(k) % motions.size()], everything};
    stage.prepare(step, *state, trials.serial);
    run(step, *state);
  });
}

}  // namespace

void try_stage(const ElementCulling& stage, StageTrials& trials) {
  try_pairs<CullingTrials>(stage, trials);
  std::vector<ElementPair> pairs;
  for (Index a = 0; a < 40; ++a)
    for (Index b = a; b < 40; ++b) pairs.push_back({a, b});
  PairBatch batch;
  batch.contact_free.reserve(pairs.size());
  count_allocations(stage, trials, [&](const Step& step, StageState& state) {
    batch.assign(pairs);
    stage.run(step, state, 0, batch);
  });
}

void try_stage(const BroadPhase& stage, StageTrials& trials) {
  try_pairs<BroadTrials>(stage, trials);
  Work work;
  count_allocations(stage, trials, [&](const Step& step, StageState& state) {
    const std::size_t blocks = stage.blocks(step, state, trials.serial);
    for (std::size_t block = 0; block < blocks; ++block) stage.run(step, state, 0, block, work);
    work.pairs.clear();
  });
}

}  // namespace volccd::detail
