#include <volccd/paper2011/provot.hpp>

#include <cassert>

#include <volccd/narrowphase/contact_frame.hpp>
#include <volccd/paper2011/provot_test.hpp>

namespace volccd {
namespace {

using reference::MovingPoint;

std::array<MovingPoint<double>, 4> points_of(const detail::TestPoints& x) {
  std::array<MovingPoint<double>, 4> points;
  for (std::size_t p = 0; p < 4; ++p) points[p] = {{x[p][0], x[p][1], x[p][2]}, {x[p][3], x[p][4], x[p][5]}};
  return points;
}

}  // namespace

const Options<Provot::Config>& Provot::options() {
  static const Options<Config> table = [] {
    Options<Config> options;
    options.add("tolerance", &Config::tolerance, 0, 1e-3, "by how much weights may lie outside [0,1]");
    return options;
  }();
  return table;
}

void Provot::run(const Step& step, StageState&, unsigned, const TestBlock& block, std::vector<Contact>& contacts,
                 NarrowCounters& counters) const {
  assert(step.motion.control_points() == 2 && step.separation == 0);
  for (std::size_t i = 0; i < block.size(); ++i) {
    const detail::TestPoints x = detail::test_points(step.motion, block.vertices(i));
    const auto answer = reference::provot_test(block.kind(), points_of(x), config_.tolerance, step.t_max);
    counters.degenerate += answer.degenerate ? 1 : 0;
    if (!answer.touches) continue;
    Contact contact = detail::contact_at(block.kind(), block.vertices(i), x, 2, answer.t, answer.side);
    contact.at_start = contact.toi == 0;
    contacts.push_back(contact);
  }
}

StageDescriptor<NarrowPhase> describe_provot() {
  return describe_stage<NarrowPhase, Provot>(
      "provot", "the test of 2011: roots of the cubic and inside test, scalar (Provot; Bridson et al.)",
      Guarantee::approximate);
}

}  // namespace volccd
