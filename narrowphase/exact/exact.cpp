#include <volccd/narrowphase/exact/exact.hpp>

#include <volccd/narrowphase/contact_frame.hpp>
#include <volccd/narrowphase/exact/exact_predicates.hpp>

namespace volccd {

void Exact::run(const Step& step, StageState&, unsigned, const TestBlock& block, std::vector<Contact>& contacts,
                NarrowCounters& counters) const {
  TestMotion motion{block.kind(), step.motion.control_points(), {}};
  for (std::size_t test = 0; test < block.size(); ++test) {
    const std::array<Index, 4>& vertices = block.vertices(test);
    motion.points = detail::test_points(step.motion, vertices);
    const ExactAnswer answer = exact_first_touch(motion, step.t_max, step.separation);
    counters.degenerate += answer.degenerate ? 1 : 0;
    if (!answer.touches) continue;
    contacts.push_back(detail::contact_at(block.kind(), vertices, motion.points, motion.control_points, answer.toi,
                                          answer.side, step.separation));
    contacts.back().at_start = answer.reason == TouchCase::at_start;
  }
}

StageDescriptor<NarrowPhase> describe_exact() {
  return describe_stage<NarrowPhase, Exact>(
      "exact", "rational arithmetic and algebraic numbers: the judge of the others, slow", Guarantee::exact);
}

}  // namespace volccd
