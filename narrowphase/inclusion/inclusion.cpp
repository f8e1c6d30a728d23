#include <volccd/narrowphase/inclusion/inclusion.hpp>

#include <volccd/narrowphase/contact_frame.hpp>
#include <volccd/narrowphase/detail/clearly_separated.hpp>
#include <volccd/narrowphase/detail/close_at_start.hpp>
#include <volccd/narrowphase/exact/exact_predicates.hpp>
#include <volccd/narrowphase/inclusion/detail/crossing_block.hpp>
#include <volccd/narrowphase/inclusion/detail/inclusion_search.hpp>

namespace volccd {

using namespace detail;

const Options<Inclusion::Config>& Inclusion::options() {
  static const Options<Config> table = [] {
    Options<Config> options;
    options.add("time_tolerance", &Config::time_tolerance, 1e-12, 1e-3,
                "how early a contact may be reported, in steps (never late)");
    options.add("undecided", &Config::undecided, {{"report", Undecided::report}, {"exact", Undecided::exact}},
                "report tests that rounding leaves open, or decide them in rational arithmetic");
    options.add("max_intervals", &Config::max_intervals, 1, 1'000'000,
                "intervals of the step that a search examines before it is given up as undecided");
    options.add("exact_bits", &Config::exact_bits, 1, 4096,
                "bits that a test's coordinates may span for `exact` to decide what the search gives up");
    options.renamed("most_parts", "max_intervals").renamed("max_parts", "max_intervals");
    return options;
  }();
  return table;
}

namespace {

/// Pre: close.contains(i).
Contact contact_at_start(const Step& step, const TestBlock& block, const CloseAtStart& close, std::size_t i) {
  const std::array<Index, 4>& vertices = block.vertices(i);
  Contact contact = contact_near(block.kind(), vertices, test_points(step.motion, vertices),
                                 step.motion.control_points(), 0, close.closest(i));
  contact.at_start = true;
  return contact;
}

}  // namespace

void Inclusion::test_one(const Step& step, FeatureKind kind, const std::array<Index, 4>& vertices,
                         std::vector<Contact>& contacts, NarrowCounters& counters) const {
  const TestPoints x = test_points(step.motion, vertices);
  const int points = step.motion.control_points();
  InclusionAnswer answer =
      inclusion_search(kind, x, points, step.separation, config_.time_tolerance, config_.max_intervals, step.t_max);
  if (answer.outcome == InclusionAnswer::Outcome::undecided) {
    ++counters.undecided;
    const TestMotion motion{kind, points, x};
    const bool decide = config_.undecided == Undecided::exact ||
                        (answer.unsettled && coordinate_bits(motion, step.separation) <= config_.exact_bits);
    if (decide) {
      // For the whole step, so that the answer does not depend on t_max.
      const ExactAnswer exact = exact_first_touch(motion, 1, step.separation);
      if (!exact.touches || exact.toi > step.t_max) return;
      counters.degenerate += exact.degenerate ? 1 : 0;
      answer.toi = exact.toi;
      answer.side = exact.side;
      answer.at_start = exact.reason == TouchCase::at_start;
    }
  }
  if (answer.outcome == InclusionAnswer::Outcome::apart) return;
  contacts.push_back(answer.closest ? contact_near(kind, vertices, x, points, answer.toi, *answer.closest)
                                    : contact_at(kind, vertices, x, points, answer.toi, answer.side, step.separation));
  contacts.back().at_start = answer.at_start;
}

void Inclusion::run(const Step& step, StageState&, unsigned, const TestBlock& block, std::vector<Contact>& contacts,
                    NarrowCounters& counters) const {
  const FeatureKind kind = block.kind();
  if (step.motion.control_points() != 2 || step.separation > 0) {
    std::array<std::uint8_t, TestBlock::kCapacity> keep;
    keep.fill(1);
    drop_clearly_separated(block, step.separation, keep);
    CloseAtStart close;
    if (step.separation > 0) close.find(block, step.separation, keep);
    for (std::size_t i = 0; i < block.size(); ++i) {
      if (keep[i] == 0) continue;
      if (step.separation > 0 && close.contains(i))
        contacts.push_back(contact_at_start(step, block, close, i));
      else
        test_one(step, kind, block.vertices(i), contacts, counters);
    }
    return;
  }
  CoplanarityBlock cubics;
  CrossingBlock crossings;
  cubics.compute(block, true);
  crossings.gather(block, cubics);
  crossings.decide(config_.time_tolerance);
  for (std::size_t i = 0; i < crossings.size(); ++i) {
    if (crossings.apart(i)) continue;
    const std::array<Index, 4>& vertices = block.vertices(crossings.source(i));
    if (!crossings.touches(i))
      test_one(step, kind, vertices, contacts, counters);
    else if (crossings.toi(i) <= step.t_max)
      contacts.push_back(
          contact_at(kind, vertices, test_points(step.motion, vertices), 2, crossings.toi(i), crossings.side(i)));
  }
}

void Inclusion::find_at_start(const Step& step, const TestBlock& block, std::vector<Contact>& contacts,
                              std::span<std::uint8_t> keep) const {
  if (step.separation == 0) return;
  CloseAtStart close;
  close.find(block, step.separation, keep);
  for (std::size_t i = 0; i < block.size(); ++i) {
    if (keep[i] == 0 || !close.contains(i)) continue;
    contacts.push_back(contact_at_start(step, block, close, i));
    keep[i] = 0;
  }
}

StageDescriptor<NarrowPhase> describe_inclusion() {
  return describe_stage<NarrowPhase, Inclusion>(
      "inclusion", "certified: intervals of the step proven free of contact, none missed", Guarantee::conservative);
}

}  // namespace volccd
