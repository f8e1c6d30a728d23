// Promises of `inclusion` beyond those of every narrow phase, which check_stage() checks: on undecided tests, with
// `undecided=exact`, and for an end of the step at the time of a contact.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include <volccd/narrowphase/inclusion/inclusion.hpp>
#include <volccd/oracle/cases/attack_cases.hpp>
#include <volccd/oracle/cases/instruction_sets.hpp>
#include <volccd/oracle/cases/known_misses.hpp>

#include "support/one_test.hpp"
#include "support/run_seeds.hpp"
#include "support/stages.hpp"

namespace volccd::test::inclusion_promises {
namespace {

using cases::Attack;
using cases::attack_test;
using cases::Case;
using cases::Choices;
using cases::Coordinates;
using cases::Curve;
using cases::InstructionSets;
using cases::known_misses;
using cases::KnownMiss;
using cases::near_degenerate_test;
using cases::Separation;
using cases::separation_attacks;
using cases::touching_attacks;

struct Answer {
  std::vector<Contact> contacts;
  NarrowCounters counters;

  bool found() const { return !contacts.empty(); }
  bool undecided() const { return counters.undecided > 0; }
  double toi() const { return contacts.front().toi; }
};

std::string describe(const Answer& answer, const Case& c) {
  char text[96];
  std::snprintf(text, sizeof text, " (time %a, %d undecided)\n", answer.found() ? answer.toi() : -1,
                static_cast<int>(answer.counters.undecided));
  return text + to_text(c);
}

/// The size is a power of two, so that its fractions are doubles.
Case enlarged(Case c) {
  for (auto& set : c.sets)
    for (Curve& p : set)
      for (Vec3& x : p) x *= 0x1p600;
  c.separation *= 0x1p600;
  return c;
}

/// Each case runs with one of the instruction sets, in turn.
class Promises {
 public:
  std::string judge(const Case& c) {
    std::string wrong;
    sets_.with(cases_++, [&](const char*) { wrong = find_wrong(c); });
    return wrong;
  }

 private:
  std::string find_wrong(const Case& c) {
    const Answer answer = run(plain_, c, 1);
    std::string what;
    if (answer.found() && answer.undecided() && !near(c, answer) && !spans_too_much(c))
      what = "undecided, and not near";
    if (what.empty() && answer.found()) what = wrong_end(c, answer);
    if (what.empty() && answer.undecided()) what = wrong_decision(c, answer);
    return what.empty() ? "" : what + describe(answer, c);
  }

  Answer run(const Inclusion& inclusion, const Case& c, double t_max) {
    test_.set(c, t_max);
    Answer answer;
    run_stage(inclusion, test_.step(), test_.kind(), test_.pairs(), answer.contacts, answer.counters);
    return answer;
  }

  /// A contact is found if the step ends at its time.
  std::string wrong_end(const Case& c, const Answer& answer) {
    return run(plain_, c, answer.toi()).contacts == answer.contacts ? "" : "another answer for t_max = time";
  }

  /// An undecided test is early by no more than the tolerance, and `undecided=exact` decides it as exact arithmetic
  /// does.
  std::string wrong_decision(const Case& c, const Answer& answer) {
    const Coordinates coordinates(c);
    const ExactAnswer truth = exact_first_touch(coordinates.motion(), 1, c.separation);
    if (truth.touches && truth.toi - answer.toi() > kTolerance && !spans_too_much(c)) return "too early";
    const Answer decided = run(deciding_, c, 1);
    if (decided.found() != truth.touches) return "undecided=exact decides otherwise";
    if (!truth.touches) return "";
    if (!(decided.toi() <= truth.toi && truth.toi - decided.toi() <= kTolerance)) return "undecided=exact: wrong time";
    if (decided.contacts.front().at_start != (truth.reason == TouchCase::at_start))
      return "undecided=exact: wrong at_start";
    return "";
  }

  bool near(const Case& c, const Answer& answer) {
    constexpr double kSeparationRounding = 0x1p-46;  // the separation is itself rounded
    const Coordinates coordinates(c);
    const double size = std::min(coordinates.size(), 0x1p1023);
    if (size == 0) return true;
    if (size < 0x1p-900) return !std::isfinite(c.separation * 0x1p600) || near(enlarged(c), answer);
    const double within = c.separation * (1 + kSeparationRounding) + size * kUndecidedDistance;
    return !std::isfinite(within) || compare_distance(coordinates.motion(), answer.toi(), within) <= 0;
  }

  /// `exact` is not used for such tests.
  static bool spans_too_much(const Case& c) {
    return coordinate_bits(Coordinates(c).motion(), c.separation) > Inclusion::Config{}.exact_bits;
  }

  static constexpr double kTolerance = 1e-9;
  Inclusion plain_{{.time_tolerance = kTolerance}};
  Inclusion deciding_{{.time_tolerance = kTolerance, .undecided = Undecided::exact}};
  InstructionSets sets_;
  std::size_t cases_ = 0;
  OneTest test_;
};

void expect_promises(std::uint64_t first, int cases, const std::function<Case(Choices&)>& make) {
  Promises promises;
  run_seeds(first, cases, [&](Choices& choices) { return promises.judge(make(choices)); });
}

TEST(InclusionPromises, AreKeptOnKnownMisses) {
  Promises promises;
  for (const KnownMiss& known : known_misses()) EXPECT_EQ(promises.judge(known.test), "") << known.name;
}
TEST(InclusionPromises, AreKeptOnNearDegenerateTests) {
  for (const Separation separation : {Separation::none, Separation::some})
    expect_promises(1, separation == Separation::none ? 3000 : 1000,
                    [=](Choices& choices) { return near_degenerate_test(choices, separation); });
}
TEST(LongInclusionPromises, AreKeptOnNearDegenerateTests) {
  for (const Separation separation : {Separation::none, Separation::some})
    expect_promises(20'000'000, 10'000, [=](Choices& choices) { return near_degenerate_test(choices, separation); });
}

class InclusionAttack : public testing::TestWithParam<Attack> {};
class LongInclusionAttack : public InclusionAttack {};

TEST_P(InclusionAttack, KeepsThePromises) {
  expect_promises(1, GetParam().cases, [](Choices& choices) { return attack_test(choices, GetParam()); });
}
TEST_P(LongInclusionAttack, KeepsThePromises) {
  expect_promises(40'000'000, 5 * GetParam().cases, [](Choices& choices) { return attack_test(choices, GetParam()); });
}

std::vector<Attack> all_attacks() {
  std::vector<Attack> all(touching_attacks().begin(), touching_attacks().end());
  all.insert(all.end(), separation_attacks().begin(), separation_attacks().end());
  return all;
}
std::string attack_name(const testing::TestParamInfo<Attack>& info) { return info.param.name; }

INSTANTIATE_TEST_SUITE_P(Families, InclusionAttack, testing::ValuesIn(all_attacks()), attack_name);
INSTANTIATE_TEST_SUITE_P(Families, LongInclusionAttack, testing::ValuesIn(all_attacks()), attack_name);

}  // namespace
}  // namespace volccd::test::inclusion_promises
