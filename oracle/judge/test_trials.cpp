// Feature filters and narrow phases, on blocks of generated tests.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include <fmt/format.h>

#include <volccd/core/random.hpp>
#include <volccd/oracle/cases/attack_cases.hpp>
#include <volccd/oracle/cases/known_misses.hpp>
#include <volccd/oracle/cases/test_scene.hpp>
#include <volccd/oracle/judge/detail/stage_trials.hpp>

namespace volccd::detail {

using cases::Case;
using cases::Choices;

namespace {

/// The answer of a stage to a test; for a filter, whether the test is kept.
struct Answer {
  bool found = false;
  Contact contact{};
  bool undecided = false;  ///< known only for tests that are alone in their block

  bool same(const Answer& other) const { return found == other.found && (!found || contact == other.contact); }
};

/// Tests of one step.
struct Group {
  StepChoice choice;
  double separation, t_max;
  std::vector<Case> tests;
};

/// Some generators make tests that are slow in exact arithmetic; these are used for few tests.
const cases::Attack& any_attack(Choices& choices, std::span<const cases::Attack> attacks) {
  int sum = 0;
  for (const cases::Attack& attack : attacks) sum += std::min(attack.cases, 1000);
  int at = choices.below(sum);
  for (const cases::Attack& attack : attacks) {
    at -= std::min(attack.cases, 1000);
    if (at < 0) return attack;
  }
  return attacks.back();
}

Case make_test(Choices& choices, const StepChoice& step) {
  const bool vf = step.kind == FeatureKind::vf;
  if (choices.below(2))
    return cases::near_degenerate(choices, step.kind, step.control_points, vf ? 1 : 2, vf ? 3 : 2,
                                  step.separation ? cases::Separation::some : cases::Separation::none);
  const auto attacks = step.separation ? cases::separation_attacks() : cases::touching_attacks();
  return any_attack(choices, attacks).make(choices, step.kind, step.control_points);
}

/// Makes a test; most of those that take long in exact arithmetic are replaced by others. Used where each test is
/// judged.
Case make_quick_test(Choices& choices, const StepChoice& step) {
  constexpr int kMaxBits = 300;
  Case c = make_test(choices, step);
  for (int i = 0; i < 4 && !choices.one_in(16) && coordinate_bits(cases::Coordinates(c).motion()) > kMaxBits; ++i)
    c = make_test(choices, step);
  return c;
}

/// Makes a single test with a separation, which it keeps: tests that lie exactly at their separation are the difficult
/// ones, and in a group only the first one does.
Group make_separated(Choices& choices, int max_control_points, bool quick) {
  Group group{choose_step(choices, max_control_points, true), 0, 1, {}};
  group.choice.separation = true;
  group.tests.push_back(quick ? make_quick_test(choices, group.choice) : make_test(choices, group.choice));
  group.separation = group.tests[0].separation;
  group.t_max = choose_t_max(choices, group.tests[0]);
  return group;
}

/// Makes a group of tests, all with the separation of the first. `quick`: as in make_quick_test().
Group make_group(Choices& choices, int max_control_points, bool separation, bool quick) {
  Group group{choose_step(choices, max_control_points, separation), 0, 1, {}};
  const std::size_t size = choices.one_in(4) ? TestBlock::kCapacity : 1 + static_cast<std::size_t>(choices.below(20));
  for (std::size_t i = 0; i < size; ++i) {
    Case c = quick ? make_quick_test(choices, group.choice) : make_test(choices, group.choice);
    if (i == 0) group.separation = c.separation;
    if (c.separation != group.separation) c.separation = group.separation, c.touch = -1;
    group.tests.push_back(std::move(c));
  }
  group.t_max = choose_t_max(choices, group.tests.front());
  return group;
}

/// A kind of stage that processes blocks of tests.
class BlockStage {
 public:
  explicit BlockStage(const Stage& stage) : stage_(stage) {}
  virtual ~BlockStage() = default;

  const Stage& stage() const { return stage_; }
  virtual void prepare(const Step& step, StageState& state, Executor& executor) const {
    stage_.prepare(step, state, executor);
  }
  /// Answers to the tests of the block, in its order.
  virtual std::vector<Answer> run(const Step& step, StageState& state, unsigned worker, const TestBlock& block) = 0;
  /// The same without answers and without memory of its own.
  virtual void run_quietly(const Step& step, StageState& state, const TestBlock& block) = 0;
  /// Compares an answer with the exact answer to the test.
  virtual void judge(const Case& c, double t_max, const Answer& answer, const std::string& where) = 0;
  /// Whether an answer depends on the coordinates alone: not on the instruction set, and on t_max only as far as a
  /// contact may lie after it.
  virtual bool is_unique() const = 0;

 private:
  const Stage& stage_;
};

class FilterStage final : public BlockStage {
 public:
  FilterStage(const FeatureFilter& filter, StageTrials& trials)
      : BlockStage(filter), filter_(filter), trials_(trials) {}

  void prepare(const Step& step, StageState& state, Executor& executor) const override {
    filter_.prepare(step, state, executor);
    filter_.prepare_select(step, state, executor);
  }
  std::vector<Answer> run(const Step& step, StageState& state, unsigned worker, const TestBlock& block) override {
    std::vector<std::uint8_t> keep(block.padded_size(), 1);
    std::vector<FeaturePair> tests(block.pairs().begin(), block.pairs().end());
    tests.resize(filter_.select(step, state, worker, block.kind(), tests));
    filter_.run(step, state, worker, block, keep);
    std::vector<Answer> answers(block.size());
    std::size_t next = 0;
    for (std::size_t i = 0; i < block.size(); ++i) {
      const bool selected = next < tests.size() && tests[next] == block.pair(i);
      answers[i].found = selected && keep[i] != 0;
      next += selected;
    }
    trials_.expect(kSelects, next == tests.size(), [&] {
      return "select() leaves " + std::to_string(tests.size()) + " tests of a block of " +
             std::to_string(block.size()) + ", of which " + std::to_string(tests.size() - next) +
             " are no tests of the block, or not in its order\n";
    });
    return answers;
  }
  void run_quietly(const Step& step, StageState& state, const TestBlock& block) override {
    std::array<FeaturePair, TestBlock::kCapacity> tests;
    std::copy(block.pairs().begin(), block.pairs().end(), tests.begin());
    (void)filter_.select(step, state, 0, block.kind(), {tests.data(), block.size()});
    std::uint8_t keep[TestBlock::kCapacity];
    std::fill(std::begin(keep), std::end(keep), std::uint8_t{1});
    filter_.run(step, state, 0, block, {keep, block.padded_size()});
  }
  void judge(const Case& c, double t_max, const Answer& answer, const std::string& where) override {
    trials_.expect(
        kLosesNoContact, answer.found || !cases::touches(c, t_max),
        [&] { return where + "drops, with t_max " + std::to_string(t_max) + ":\n" + to_text(c); },
        trials_.conservative());
  }
  bool is_unique() const override { return false; }

 private:
  const FeatureFilter& filter_;
  StageTrials& trials_;
};

class NarrowStage final : public BlockStage {
 public:
  NarrowStage(const NarrowPhase& narrow, StageTrials& trials) : BlockStage(narrow), narrow_(narrow), trials_(trials) {}

  std::vector<Answer> run(const Step& step, StageState& state, unsigned worker, const TestBlock& block) override {
    std::vector<Contact> contacts;
    NarrowCounters counters;
    narrow_.run(step, state, worker, block, contacts, counters);
    std::vector<Answer> answers(block.size());
    std::size_t next = 0;
    for (std::size_t i = 0; i < block.size(); ++i) {
      answers[i].undecided = counters.undecided > 0;
      if (next == contacts.size() || contacts[next].vertices != block.vertices(i)) continue;
      answers[i].found = true;
      answers[i].contact = contacts[next++];
      well_formed_ = well_formed_ && answers[i].contact.kind == block.kind();
    }
    well_formed_ = well_formed_ && next == contacts.size();
    expect_starts(step, block, answers);
    return answers;
  }
  void run_quietly(const Step& step, StageState& state, const TestBlock& block) override {
    contacts_.clear();
    contacts_.reserve(TestBlock::kCapacity);
    NarrowCounters counters;
    narrow_.run(step, state, 0, block, contacts_, counters);
  }
  void judge(const Case& c, double t_max, const Answer& answer, const std::string& where) override {
    const auto text = [&](const std::string& what) {
      return [&, what] {
        char at[96];
        std::snprintf(at, sizeof at, "%s, with t_max %a, time %a:\n", what.c_str(), t_max, answer.contact.toi);
        return where + at + to_text(c);
      };
    };
    const Contact& contact = answer.contact;
    const bool finite = !answer.found || (contact.normal.allFinite() && contact.point.allFinite() && contact.toi >= 0 &&
                                          contact.toi <= t_max);
    trials_.expect(kWellFormed, well_formed_ && finite, text("a contact that is no answer to its test"));
    well_formed_ = true;
    judge_touch(c, t_max, answer, text);
    if (answer.found && !answer.undecided)
      trials_.expect(kNear, near_at(c, answer.contact.toi), text("reports, and not near"), trials_.conservative());
  }
  bool is_unique() const override { return true; }

 private:
  void expect_starts(const Step& step, const TestBlock& block, const std::vector<Answer>& answers) {
    std::vector<Contact> contacts;
    std::vector<std::uint8_t> keep(block.padded_size(), 1);
    narrow_.find_at_start(step, block, contacts, keep);
    std::size_t next = 0;
    bool right = true;
    for (std::size_t i = 0; i < block.size(); ++i) {
      if (keep[i] != 0) continue;
      right = right && next < contacts.size() && contacts[next].at_start && answers[i].found &&
              answers[i].contact == contacts[next];
      ++next;
    }
    trials_.expect(kStarts, right && next == contacts.size(), [&] {
      return fmt::format("find_at_start() of {} tests appends {} contacts and takes {} tests out\n", block.size(),
                         contacts.size(), next);
    });
  }

  template <class Text>
  void judge_touch(const Case& c, double t_max, const Answer& answer, const Text& text) {
    const bool required = trials_.conservative();
    const ExactAnswer truth = exact_first_touch(cases::Coordinates(c).motion(), t_max, c.separation);
    trials_.expect(kLosesNoContact, answer.found || !truth.touches, text("misses"), required);
    trials_.expect(kInventsNoContact, !answer.found || truth.touches, text("invents"), trials_.exact());
    if (answer.found && !answer.undecided && !truth.touches)
      trials_.expect(kCertain, touches_soon(c, t_max), text("reports as decided"), required);
    if (!answer.found || !truth.touches) return;
    const double toi = answer.contact.toi;
    trials_.expect(kTimes, toi <= truth.toi, text("reports late"), required);
    if (truth.reason == TouchCase::at_start)
      trials_.expect(kTimes, toi == 0 && answer.contact.at_start, text("does not report as touching at the start"),
                     required);
    if (answer.undecided) return;
    trials_.expect(kCertain, true, text(""), required);
    trials_.expect(kTimes, truth.toi - toi <= narrow_.time_tolerance(), text("reports too early"), required);
    trials_.expect(kTimes, !answer.contact.at_start || truth.reason == TouchCase::at_start,
                   text("reports as touching at the start"), required);
  }

  /// A narrow phase may report a contact after t_max if its reported time is not.
  bool touches_soon(const Case& c, double t_max) const {
    const double until = std::min(1.0, t_max + narrow_.time_tolerance());
    return until > t_max && exact_first_touch(cases::Coordinates(c).motion(), until, c.separation).touches;
  }

  /// Whether the features are within the separation, or touch, but for what they move within the tolerance in time.
  bool near_at(const Case& c, double toi) const {
    constexpr double kSeparationRounding = 0x1p-46;  // the separation is itself rounded
    const double size = std::min(cases::Coordinates(c).size(), 0x1p1023);
    // The bounds of the tests of tiny size are not doubles.
    if (size < 0x1p-900) return true;
    const double within = c.separation * (1 + kSeparationRounding) + size * (64 * narrow_.time_tolerance() + 0x1p-40);
    return !std::isfinite(within) || compare_distance(cases::Coordinates(c).motion(), toi, within) <= 0;
  }

  const NarrowPhase& narrow_;
  StageTrials& trials_;
  std::vector<Contact> contacts_;
  bool well_formed_ = true;
};

/// Runs the stage on the generated groups, each in several ways.
class BlockTrials {
 public:
  BlockTrials(BlockStage& stage, StageTrials& trials)
      : stage_(stage), trials_(trials), kept_(stage.stage().make_state()) {}

  /// `remembers`: whether answers may depend on earlier steps.
  void run(const Group& group, bool remembers, const std::string& where) {
    for (std::size_t i = 0; i < group.tests.size(); ++i) scene_.set(static_cast<Index>(i), group.tests[i]);
    const Step step = scene_.step(group.choice.control_points, group.separation, group.t_max);
    std::vector<FeaturePair> pairs;
    for (std::size_t i = 0; i < group.tests.size(); ++i)
      pairs.push_back(scene_.pair(group.choice.kind, static_cast<Index>(i)));
    stage_.prepare(step, *kept_, *trials_.threads);
    std::vector<Answer> together = answers(step, *kept_, group.choice.kind, pairs, 0);
    compare_batches(step, group, pairs, together, where);
    const auto fresh = stage_.stage().make_state();
    stage_.prepare(step, *fresh, trials_.serial);
    const std::vector<Answer> anew = answers(step, *fresh, group.choice.kind, pairs, 0);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      stage_.judge(group.tests[i], group.t_max, together[i], where);
      if (remembers && !anew[i].same(together[i]))
        stage_.judge(group.tests[i], group.t_max, anew[i], where + "(new state) ");
      if (!remembers)
        trials_.expect(kSameAfterOtherSteps, anew[i].same(together[i]),
                       [&] { return where + "a new state gives a different answer:\n" + to_text(group.tests[i]); });
    }
    if (!stage_.is_unique()) return;
    trials_.with_another_set([&](const char* set) {
      const std::vector<Answer> other = answers(step, *kept_, group.choice.kind, pairs, 0);
      for (std::size_t i = 0; i < pairs.size(); ++i)
        trials_.expect(
            kSameOnEverySet, other[i].same(together[i]),
            [&] { return where + "a different answer with " + set + ":\n" + to_text(group.tests[i]); },
            trials_.conservative());
    });
    compare_earlier_ends(group, pairs, together, where);
  }

 private:
  /// Runs the tests with ends of the step at, before and after a contact, and in the middle.
  void compare_earlier_ends(const Group& group, std::span<const FeaturePair> pairs, std::span<const Answer> all,
                            const std::string& where) {
    std::vector<double> ends{group.t_max / 2};
    const auto some =
        std::find_if(all.begin(), all.end(), [](const Answer& a) { return a.found && a.contact.toi > 0; });
    if (some != all.end()) {
      const double toi = some->contact.toi;
      for (const double end : {std::nextafter(toi, 0), toi, std::nextafter(toi, 1)})
        if (end < group.t_max) ends.push_back(end);
    }
    for (const double end : ends) {
      const Step step = scene_.step(group.choice.control_points, group.separation, end);
      stage_.prepare(step, *kept_, trials_.serial);
      const std::vector<Answer> now = answers(step, *kept_, group.choice.kind, pairs, 0);
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        const bool kept = now[i].found ? now[i].same(all[i]) : !all[i].found || all[i].contact.toi >= end;
        trials_.expect(
            kEarlierEnd, kept,
            [&] {
              char at[96];
              std::snprintf(at, sizeof at, "with t_max %a, then %a, other contacts before the earlier end:\n",
                            group.t_max, end);
              return where + at + to_text(group.tests[i]);
            },
            trials_.conservative());
      }
    }
  }

  std::vector<Answer> answers(const Step& step, StageState& state, FeatureKind kind, std::span<const FeaturePair> pairs,
                              unsigned worker) {
    block_.gather(step, kind, pairs);
    return stage_.run(step, state, worker, block_);
  }

  /// Runs each test alone, with the workers in turn, and all tests in reverse order with the last worker.
  void compare_batches(const Step& step, const Group& group, std::vector<FeaturePair> pairs,
                       std::vector<Answer>& together, const std::string& where) {
    const unsigned workers = trials_.threads->workers();
    std::vector<Answer> alone;
    for (std::size_t i = 0; i < pairs.size(); ++i)
      alone.push_back(answers(step, *kept_, group.choice.kind, {&pairs[i], 1}, static_cast<unsigned>(i) % workers)[0]);
    std::reverse(pairs.begin(), pairs.end());
    std::vector<Answer> backwards = answers(step, *kept_, group.choice.kind, pairs, workers - 1);
    std::reverse(backwards.begin(), backwards.end());
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      trials_.expect(kSameInEveryBatch, alone[i].same(together[i]) && backwards[i].same(together[i]), [&] {
        return where + "test " + std::to_string(i) + " of a block of " + std::to_string(pairs.size()) +
               " has a different answer when it is alone, or in reverse order with another worker:\n" +
               to_text(group.tests[i]);
      });
      together[i].undecided = alone[i].undecided;
    }
  }

  BlockStage& stage_;
  StageTrials& trials_;
  std::unique_ptr<StageState> kept_;
  cases::TestScene scene_{TestBlock::kCapacity};
  TestBlock block_;
};

/// Ordinary tests of both kinds, about half of which touch. They are the same for every seed, and none of them is
/// undecided: a few of 100,000 random ones are, for which a narrow phase may use exact arithmetic, which allocates.
void count_allocations(BlockStage& stage, StageTrials& trials, int control_points, bool required) {
  cases::TestScene scene(TestBlock::kCapacity);
  std::vector<FeaturePair> pairs[2];
  for (Index i = 0; i < TestBlock::kCapacity; ++i)
    for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee})
      pairs[static_cast<std::size_t>(kind)].push_back(scene.pair(kind, i));
  const auto state = stage.stage().make_state();
  TestBlock block;
  Random random(1);
  Case c;
  c.control_points = control_points;
  c.sets = {std::vector<cases::Curve>(1), std::vector<cases::Curve>(3)};
  trials.expect_no_allocation(
      [&](int) {
        for (Index i = 0; i < TestBlock::kCapacity; ++i) {
          for (auto& set : c.sets)
            for (cases::Curve& p : set)
              for (Vec3& x : p) x = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
          scene.set(i, c);
        }
        const Step step = scene.step(control_points, 0, 1);
        stage.prepare(step, *state, trials.serial);
        for (const FeatureKind kind : {FeatureKind::vf, FeatureKind::ee}) {
          block.gather(step, kind, pairs[static_cast<std::size_t>(kind)]);
          stage.run_quietly(step, *state, block);
        }
      },
      required);
}

void try_blocks(BlockStage& stage, StageTrials& trials, int max_control_points, bool separation, bool is_filter) {
  BlockTrials blocks(stage, trials);
  for (const cases::KnownMiss& known : cases::known_misses()) {
    const StepChoice choice{known.test.kind, known.test.control_points, false};
    if (choice.control_points <= max_control_points)
      blocks.run({choice, 0, 1, {known.test}}, is_filter, fmt::format("{}: ", known.name));
  }
  trials.each_trial(trials.config.trials, [&](Choices& choices, const std::string& where) {
    blocks.run(make_group(choices, max_control_points, separation, !is_filter), is_filter, where);
    for (int i = 0; i < (is_filter ? 12 : 2) && separation; ++i)
      blocks.run(make_separated(choices, max_control_points, !is_filter), is_filter, where);
  });
  // Exact arithmetic allocates memory.
  const bool required = is_filter || !trials.exact();
  for (int points = 2; points <= max_control_points; ++points) count_allocations(stage, trials, points, required);
}

}  // namespace

void try_stage(const FeatureFilter& stage, StageTrials& trials) {
  FilterStage filter(stage, trials);
  try_blocks(filter, trials, 3, true, true);
}

void try_stage(const NarrowPhase& stage, StageTrials& trials) {
  NarrowStage narrow(stage, trials);
  try_blocks(narrow, trials, stage.max_control_points(), stage.handles_separation(), false);
}

}  // namespace volccd::detail
