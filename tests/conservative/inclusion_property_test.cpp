// What the header of `inclusion` promises, on tests that nearly touch.
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <volccd/narrowphase/inclusion.hpp>

#include "conservative/one_test.hpp"
#include "conservative/run_cases.hpp"

namespace volccd::test {
namespace {

constexpr double kTolerance = 1e-9;

struct Answer {
  std::vector<Contact> contacts;
  NarrowCounters counters;

  bool found() const { return !contacts.empty(); }
  const Contact& contact() const { return contacts.front(); }
};

enum class Promise {
  complete,  ///< none missed, none late, none early by more than the tolerance, undecided=exact exact, t_max respected
  near       ///< what is reported comes near
};

class InclusionProperty {
 public:
  InclusionProperty(Promise promise, Separation separation) : promise_(promise), separation_(separation) {}

  std::string operator()(Choices& choices) {
    const Case c = near_degenerate_test(choices, separation_);
    const Answer answer = run(plain_, c, 1);
    if (promise_ == Promise::near) {
      if (!answer.found() || near(c, answer.contact().toi)) return "";
      return "reported, and not near" + describe(answer) + "\n" + to_text(c);
    }
    const std::string what = c.separation > 0 ? wrong_distance(c, answer) : wrong_touch(c, answer);
    if (!what.empty()) return what + describe(answer) + "\n" + to_text(c);
    return wrong_by_then(c, answer);
  }

 private:
  Answer run(const Inclusion& inclusion, const Case& c, double t_max) {
    test_.set(c, t_max);
    Answer answer;
    inclusion.test(test_.step(), test_.kind(), test_.pairs(), answer.contacts, answer.counters);
    return answer;
  }

  std::string wrong_touch(const Case& c, const Answer& answer) {
    const ExactAnswer truth = exact_first_touch(Coordinates(c).motion());
    const std::string what = wrong_time(truth, answer);
    if (!what.empty()) return what;
    if (answer.found() && answer.counters.undecided == 0 && !truth.touches)
      return "reported, proven, and does not touch";
    if (truth.touches && truth.toi - answer.contact().toi > kTolerance) return "too early: it is at " + in_hex(truth.toi);
    const Answer decided = run(deciding_, c, 1);
    if (decided.found() != truth.touches) return "undecided=exact decides otherwise";
    const std::string decided_what = wrong_time(truth, decided);
    if (!decided_what.empty()) return "undecided=exact: " + decided_what + describe(decided);
    if (!truth.touches) return "";
    if (truth.toi - decided.contact().toi > kTolerance) return "undecided=exact: too early" + describe(decided);
    if (decided.contact().at_start != (truth.reason == TouchCase::at_start)) return "undecided=exact: wrong at_start";
    return "";
  }

  static std::string wrong_time(const ExactAnswer& truth, const Answer& answer) {
    if (!truth.touches) return "";
    if (!answer.found()) return "missed";
    if (!(answer.contact().toi <= truth.toi)) return "late";
    if (truth.reason == TouchCase::at_start && !answer.contact().at_start) return "not flagged at the start";
    return "";
  }

  std::string wrong_distance(const Case& c, const Answer& answer) {
    const TestMotion motion = Coordinates(c).motion();
    double at;
    if (!answer.found()) {
      if (c.touch >= 0) return "missed";
      return seen_within_separation(c, 1, &at) ? "missed at " + std::to_string(at) : "";
    }
    const Contact& contact = answer.contact();
    if (c.touch >= 0 && contact.toi > c.touch) return "late";
    if (compare_distance(motion, 0, c.separation) <= 0 && !(contact.toi == 0 && contact.at_start))
      return "not flagged at the start";
    if (contact.toi > 0) {
      const double before = std::nextafter(contact.toi, 0);
      if (seen_within_separation(c, before, &at)) return "late: within at " + std::to_string(at);
      if (compare_distance(motion, before, c.separation) <= 0) return "late, by little";
    }
    return "";
  }

  /// Within 2^-24 of the size, beyond the separation: proven contacts may be early by the time tolerance.
  static bool near(const Case& c, double t) {
    const Coordinates x(c);
    const double size = x.size();
    if (!(size > 0x1p-900)) return true;
    const double reach = std::min(size, 0x1p1023) * 0x1p-24;
    return compare_distance(x.motion(), t, c.separation * (1 + 0x1p-50) + reach) <= 0;
  }

  /// t_max: the same contact by its time, none before.
  std::string wrong_by_then(const Case& c, const Answer& answer) {
    if (!answer.found()) return run(plain_, c, 0.5).found() ? "found by 0.5, not by 1\n" + to_text(c) : "";
    const double toi = answer.contact().toi;
    const Answer then = run(plain_, c, toi);
    if (then.contacts != answer.contacts)
      return "another answer for t_max = time" + describe(answer) + "\n" + to_text(c);
    if (toi > 0 && run(plain_, c, std::nextafter(toi, 0)).found()) return "found before its time\n" + to_text(c);
    return "";
  }

  static std::string in_hex(double x) {
    char text[32];
    std::snprintf(text, sizeof text, "%a", x);
    return text;
  }

  static std::string describe(const Answer& answer) {
    char text[96];
    if (!answer.found()) return " (no contact)";
    std::snprintf(text, sizeof text, " (time %a%s, %d undecided)", answer.contact().toi,
                  answer.contact().at_start ? " at start" : "", static_cast<int>(answer.counters.undecided));
    return text;
  }

  Promise promise_;
  Separation separation_;
  Inclusion plain_{{.time_tolerance = kTolerance}};
  Inclusion deciding_{{.time_tolerance = kTolerance, .undecided = Undecided::exact}};
  OneTest test_;
};

TEST(InclusionProperty, MissesNothing) {
  InclusionProperty property(Promise::complete, Separation::none);
  run_shrinking(20112, 500, property);
  run_seeds(1, 3000, property);
}
TEST(InclusionProperty, MissesNothingWithinTheSeparation) {
  InclusionProperty property(Promise::complete, Separation::some);
  run_shrinking(20113, 300, property);
  run_seeds(1, 2000, property);
}
/// With a separation, searches that are cut short may report what is not so near: rare even among tests made to be near.
void expect_near(Separation separation, std::uint64_t first, int cases) {
  InclusionProperty property(Promise::near, separation);
  int not_near = 0;
  std::string last;
  for (int i = 0; i < cases; ++i) {
    Choices choices(first + static_cast<std::uint64_t>(i));
    const std::string what = property(choices);
    if (what.empty()) continue;
    ++not_near;
    last = what;
  }
  EXPECT_LE(not_near, separation == Separation::some ? cases / 50 : 0) << last;
}

TEST(InclusionProperty, ReportsWhatComesNear) {
  expect_near(Separation::none, 1, 3000);
  expect_near(Separation::some, 1, 1000);
}
TEST(LongInclusionProperty, MissesNothing) {
  InclusionProperty property(Promise::complete, Separation::none);
  run_seeds(20'000'000, 20'000, property);
}
TEST(LongInclusionProperty, MissesNothingWithinTheSeparation) {
  InclusionProperty property(Promise::complete, Separation::some);
  run_seeds(20'000'000, 20'000, property);
}
TEST(LongInclusionProperty, ReportsWhatComesNear) {
  expect_near(Separation::none, 20'000'000, 40'000);
  expect_near(Separation::some, 20'000'000, 20'000);
}

}  // namespace
}  // namespace volccd::test
