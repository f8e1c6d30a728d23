// The bytes give the kind, the number of control points, the range of exponents, t_max, and then the coordinates: for
// each, a byte that says how it is made, and the bytes of which it is made. Small integers, powers of two and copies of
// other coordinates make degenerate tests likely.
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include <volccd/narrowphase/exact/exact_predicates.hpp>
#include <volccd/narrowphase/inclusion/inclusion.hpp>
#include <volccd/oracle/cases/query_set.hpp>
#include <volccd/pipelines/registry.hpp>

#include "byte_reader.hpp"
#include "support/stages.hpp"

namespace volccd::fuzz {

namespace {

/// All registered narrow phases with their defaults, and again with undecided tests left to `exact`, if they have this
/// option.
struct Contestants {
  struct Narrow {
    std::string name;
    Guarantee guarantee;
    bool exact;  ///< it reports only contacts
    std::unique_ptr<NarrowPhase> stage;

    bool exact_in_time() const { return guarantee == Guarantee::exact; }
  };
  struct Filter {
    std::string name;
    std::unique_ptr<FeatureFilter> stage;
  };
  std::vector<Narrow> narrow_phases;
  std::vector<Filter> filters;

  Contestants() {
    const Registry registry = Registry::standard();
    for (const auto& d : registry.stages<NarrowPhase>()) {
      narrow_phases.push_back({d.name, d.guarantee, d.guarantee == Guarantee::exact, d.make({})});
      for (const OptionInfo& option : d.options)
        if (option.name == "undecided")
          narrow_phases.push_back({d.name + ":undecided=exact", d.guarantee, true, d.make({{"undecided", "exact"}})});
    }
    for (const auto& d : registry.stages<FeatureFilter>())
      if (d.guarantee != Guarantee::approximate) filters.push_back({d.name, d.make({})});
  }
};

/// `wild`: exponents of all magnitudes, which make exact arithmetic a hundred times slower.
double coordinate(ByteReader& in, std::span<const double> before, bool wild) {
  const std::uint8_t how = in.byte();
  /// A copy of an earlier point, usually with the same coordinate.
  const auto copy = [&] {
    if (before.size() < 3) return 0.0;
    return how & 128 ? before[in.below(before.size())] : before[before.size() - 3 * (1 + in.below(before.size() / 3))];
  };
  double x = 0;
  switch (how % 8) {
    case 0: x = in.small(); break;
    case 1: x = in.small() * 0x1p-4; break;
    case 2: x = copy(); break;
    case 3: x = std::nextafter(copy(), how & 8 ? 1e300 : -1e300); break;
    case 4: x = std::ldexp(how & 8 ? -1.0 : 1.0, wild ? in.small() * 8 : in.small() / 8); break;
    case 5: x = std::ldexp(in.small(), wild ? (how & 8 ? -1074 : -537) : -30); break;
    case 6: x = std::ldexp(in.small(), wild ? (how & 8 ? 1016 : 500) : 20); break;
    default: x = wild ? in.any_double() : static_cast<double>(static_cast<std::int32_t>(in.bits(4))) * 0x1p-28; break;
  }
  return std::isfinite(x) ? x : 1.0;
}

struct Test {
  FeatureKind kind;
  int control_points;
  double t_max;
  std::vector<double> coordinates;  ///< [control point][vertex][axis]

  explicit Test(Bytes bytes) {
    ByteReader in(bytes);
    const std::uint8_t what = in.byte();
    kind = what & 1 ? FeatureKind::ee : FeatureKind::vf;
    control_points = what & 2 ? 3 : 2;
    t_max = what & 4 ? in.byte() / 256.0 : 1.0;
    while (coordinates.size() < static_cast<std::size_t>(12 * control_points))
      coordinates.push_back(coordinate(in, coordinates, (what & 0x18) == 0x18));
  }

  std::vector<Vec3> points() const {
    std::vector<Vec3> result;
    for (std::size_t i = 0; i < coordinates.size(); i += 3)
      result.emplace_back(coordinates[i], coordinates[i + 1], coordinates[i + 2]);
    return result;
  }

  std::string text() const {
    std::string result =
        fmt::format("{}, {} control points, t_max {:a}:", kind == FeatureKind::vf ? "VF" : "EE", control_points, t_max);
    for (const double x : coordinates) result += fmt::format(" {:a}", x);
    return result;
  }
};

TestMotion motion_of(const Test& test, const Step& step) {
  TestMotion motion{test.kind, test.control_points, {}};
  for (Index v = 0; v < 4; ++v) motion.points[v] = step.motion.at(v);
  return motion;
}

/// Properties of a contact that hold for every narrow phase.
std::string malformed(const Test& test, const std::vector<Contact>& contacts) {
  if (contacts.size() > 1) return "reports one test twice";
  for (const Contact& c : contacts) {
    if (!(c.toi >= 0 && c.toi <= test.t_max)) return fmt::format("has time {}", c.toi);
    if (!c.normal.allFinite() || !c.point.allFinite()) return "has a normal or point that is not finite";
    for (const double w : c.weights)
      if (!std::isfinite(w)) return "has a weight that is not finite";
  }
  return {};
}

/// Why a reported time is wrong, for a narrow phase that is not approximate; empty if it is right. `exact`: the exact
/// answer over the whole step, because a test that is reported early may touch shortly after t_max. `unbounded`: the
/// test is undecided, and `exact` was not used for its coordinates; such a test may be reported at any earlier time.
std::string wrong_time(const Contestants::Narrow& narrow, const ExactAnswer& exact, double toi, bool undecided,
                       bool unbounded) {
  if (exact.touches && toi > exact.toi) return fmt::format("is late: {:a}, not {:a}", toi, exact.toi);
  if (!exact.touches) {
    // The test was reported because it may touch; inclusion_promises_test.cpp checks how near such features come.
    if (undecided && !narrow.exact) return {};
    return fmt::format("reports a contact at {:a}, there is none", toi);
  }
  // Undecided tests that `exact` has decided have the time of `exact`.
  const double early = narrow.exact_in_time() ? 0 : unbounded ? 1 : narrow.stage->time_tolerance();
  if (toi < exact.toi - early) return fmt::format("is early: {:a}, not {:a}", toi, exact.toi);
  return {};
}

/// `exact`: the exact answer up to t_max.
void check(const Test& test, const Step& step, const Contestants::Narrow& narrow, const ExactAnswer& exact,
           std::span<const FeaturePair> pairs) {
  std::vector<Contact> contacts;
  NarrowCounters counters;
  test::run_stage(*narrow.stage, step, test.kind, pairs, contacts, counters);
  std::string problem = malformed(test, contacts);
  if (problem.empty() && narrow.guarantee != Guarantee::approximate) {
    const TestMotion motion = motion_of(test, step);
    const bool undecided = counters.undecided > 0;
    const bool unbounded = undecided && !narrow.exact && coordinate_bits(motion) > Inclusion::Config{}.exact_bits;
    if (contacts.empty())
      problem = exact.touches ? fmt::format("misses a contact at {:a}", exact.toi) : "";
    else
      problem = wrong_time(narrow, exact.touches || narrow.exact_in_time() ? exact : exact_first_touch(motion),
                           contacts.front().toi, undecided, unbounded);
  }
  if (!problem.empty()) promise_broken(fmt::format("{} {}\n{}", narrow.name, problem, test.text()));
}

}  // namespace

void narrow_phase(Bytes bytes) {
  static const Contestants contestants;
  const Test test(bytes);
  const QuerySet set(test.kind, test.control_points, test.points());
  const Step step = set.step(test.t_max);
  const ExactAnswer exact = exact_first_touch(motion_of(test, step), test.t_max);
  for (const Contestants::Narrow& narrow : contestants.narrow_phases)
    if (narrow.stage->max_control_points() >= test.control_points) check(test, step, narrow, exact, set.pairs());
  TestBlock block;
  block.gather(step, test.kind, set.pairs());
  for (const Contestants::Filter& filter : contestants.filters) {
    std::array<std::uint8_t, 8> keep;
    keep.fill(1);
    test::run_stage(*filter.stage, step, block, keep);
    if (exact.touches && keep[0] == 0)
      promise_broken(fmt::format("filter {} drops a contact at {:a}\n{}", filter.name, exact.toi, test.text()));
  }
}

}  // namespace volccd::fuzz
