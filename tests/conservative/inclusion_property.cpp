#include "conservative/inclusion_property.hpp"

#include <cmath>
#include <cstdio>

#include "support/stages.hpp"

namespace volccd::test {
namespace {

/// Relative to the separation, which is itself rounded.
constexpr double kSeparationRounding = 0x1p-46;
/// Contacts that are certain are late by at most the time tolerance.
constexpr double kNearInTime = 0x1p-24;

std::string in_hex(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%a", x);
  return text;
}

std::string describe(const Answer& answer) {
  char text[96];
  if (!answer.found()) return " (no contact)";
  std::snprintf(text, sizeof text, " (time %a%s, %d undecided)", answer.contact().toi,
                answer.contact().at_start ? " at start" : "", static_cast<int>(answer.counters.undecided));
  return text;
}

std::string wrong_time(const ExactAnswer& truth, const Answer& answer) {
  if (!truth.touches) return "";
  if (!answer.found()) return "missed, it is at " + in_hex(truth.toi);
  if (!(answer.contact().toi <= truth.toi)) return "late, it is at " + in_hex(truth.toi);
  if (truth.reason == TouchCase::at_start && !answer.contact().at_start) return "not flagged at the start";
  return "";
}

/// The size is a power of two, so that its fractions are doubles.
Case enlarged(Case c) {
  for (auto& set : c.sets)
    for (Curve& p : set)
      for (Vec3& x : p) x *= 0x1p600;
  c.separation *= 0x1p600;
  return c;
}

bool finite(const Contact& contact) {
  return contact.normal.allFinite() && contact.point.allFinite() && std::isfinite(contact.weights[0]) &&
         std::isfinite(contact.weights[1]) && std::isfinite(contact.weights[2]) && std::isfinite(contact.weights[3]);
}

}  // namespace

std::string InclusionProperty::operator()(Choices& choices) { return judge(generator_(choices)); }

std::string InclusionProperty::judge(const Case& c) {
  const Answer answer = run(plain_, c, 1);
  std::string what;
  if (answer.found() && !finite(answer.contact())) what = "a contact that is not finite";
  if (what.empty() && promise_ == Promise::complete)
    what = c.separation > 0 ? wrong_distance(c, answer) : wrong_touch(c, answer);
  if (what.empty() && answer.found() && !near(c, answer) && !cut_short(c, answer)) what = "reported, and not near";
  if (what.empty()) what = wrong_target(c, answer);
  if (!what.empty()) return what + describe(answer) + "\n" + to_text(c);
  return promise_ == Promise::complete ? wrong_by_then(c, answer) : "";
}

Answer InclusionProperty::run(const Inclusion& inclusion, const Case& c, double t_max) {
  test_.set(c, t_max);
  Answer answer;
  run_stage(inclusion, test_.step(), test_.kind(), test_.pairs(), answer.contacts, answer.counters);
  return answer;
}

std::string InclusionProperty::wrong_touch(const Case& c, const Answer& answer) {
  const ExactAnswer truth = exact_first_touch(Coordinates(c).motion());
  if (c.touch >= 0 && !(truth.touches && truth.toi <= c.touch)) return "not the contact that it was made for";
  const std::string what = wrong_time(truth, answer);
  if (!what.empty()) return what;
  if (answer.found() && answer.counters.undecided == 0 && !truth.touches) return "reported, proven, and does not touch";
  if (truth.touches && truth.toi - answer.contact().toi > kTolerance && !spans_too_much(c, answer))
    return "too early: it is at " + in_hex(truth.toi);
  const Answer decided = run(deciding_, c, 1);
  if (decided.found() != truth.touches) return "undecided=exact decides otherwise";
  const std::string decided_what = wrong_time(truth, decided);
  if (!decided_what.empty()) return "undecided=exact: " + decided_what + describe(decided);
  if (!truth.touches) return "";
  if (truth.toi - decided.contact().toi > kTolerance) return "undecided=exact: too early" + describe(decided);
  if (decided.contact().at_start != (truth.reason == TouchCase::at_start)) return "undecided=exact: wrong at_start";
  return "";
}

std::string InclusionProperty::wrong_distance(const Case& c, const Answer& answer) {
  const TestMotion motion = Coordinates(c).motion();
  double at;
  if (!answer.found()) {
    if (c.touch >= 0) return "missed";
    return seen_within_separation(c, 0, 1, &at) ? "missed at " + in_hex(at) : "";
  }
  const Contact& contact = answer.contact();
  if (c.touch >= 0 && contact.toi > c.touch) return "late";
  if (compare_distance(motion, 0, c.separation) <= 0 && !(contact.toi == 0 && contact.at_start))
    return "not flagged at the start";
  if (contact.toi > 0) {
    const double before = std::nextafter(contact.toi, 0);
    if (seen_within_separation(c, 0, before, &at)) return "late: within at " + in_hex(at);
    if (compare_distance(motion, before, c.separation) <= 0) return "late, by little";
  }
  if (answer.counters.undecided > 0) return "";
  // Whether the features are within the separation at some time from the reported one to the tolerance later, as
  // rounded.
  const double until = std::min(1.0, contact.toi + kTolerance * (1 + 0x1p-20));
  return seen_within_separation(c, contact.toi, until, &at) ? "" : "too early";
}

bool InclusionProperty::near(const Case& c, const Answer& answer) {
  const double size = std::min(Coordinates(c).size(), 0x1p1023);
  if (size == 0) return true;
  if (size < 0x1p-900) return !std::isfinite(c.separation * 0x1p600) || near(enlarged(c), answer);
  const double reach = size * (answer.counters.undecided > 0 ? kUndecidedDistance : kNearInTime);
  const double within = c.separation * (1 + kSeparationRounding) + reach;
  return !std::isfinite(within) || compare_distance(Coordinates(c).motion(), answer.contact().toi, within) <= 0;
}

/// With a separation, a search that is given up does not tell how near the features come; a search that continues does.
bool InclusionProperty::cut_short(const Case& c, const Answer& answer) {
  if (c.separation == 0) return spans_too_much(c, answer);
  return answer.counters.undecided > 0 && !(run(patient_, c, 1) == answer);
}

/// The test is undecided, and `exact` was not used.
bool InclusionProperty::spans_too_much(const Case& c, const Answer& answer) {
  return answer.counters.undecided > 0 && coordinate_bits(Coordinates(c).motion()) > Inclusion::Config{}.exact_bits;
}

/// With t_max: the same contact if its time is not later than t_max, otherwise none.
std::string InclusionProperty::wrong_by_then(const Case& c, const Answer& answer) {
  if (!answer.found()) return run(plain_, c, 0.5).found() ? "found by 0.5, not by 1\n" + to_text(c) : "";
  const double toi = answer.contact().toi;
  const Answer then = run(plain_, c, toi);
  if (then.contacts != answer.contacts) return "another answer for t_max = time" + describe(answer) + "\n" + to_text(c);
  if (toi > 0 && run(plain_, c, std::nextafter(toi, 0)).found()) return "found before its time\n" + to_text(c);
  return "";
}

std::string InclusionProperty::wrong_target(const Case& c, const Answer& answer) {
  std::string wrong;
  if (c.control_points > 2 || c.separation > 0) return wrong;  // there are no vector kernels
  const auto compare = [&](const char* name) {
    const Answer other = run(plain_, c, 1);
    if (!(other == answer)) wrong += std::string("another answer on ") + name + describe(other) + ", ";
  };
  const std::size_t others = targets_.size() - 1;  // the first one is the reference
  if (others_ == Others::all)
    for (std::size_t i = 1; i <= others; ++i) targets_.with(i, compare);
  else if (others > 0)
    targets_.with(1 + compared_++ % others, compare);
  return wrong;
}

}  // namespace volccd::test
