#include <volccd/narrowphase/exact.hpp>

#include <cassert>

#include <volccd/narrowphase/detail/contact_frame.hpp>
#include <volccd/narrowphase/exact_predicates.hpp>

namespace volccd {

const Options<Exact::Config>& Exact::options() {
  static const Options<Config> table;
  return table;
}

void Exact::test(const Step& step, FeatureKind kind, std::span<const FeaturePair> pairs, std::vector<Contact>& contacts,
                 NarrowCounters& counters) const {
  assert(step.separation == 0);
  TestMotion motion{kind, step.motion.control_points(), {}};
  for (const FeaturePair& pair : pairs) {
    const std::array<Index, 4> vertices = test_vertices(step.features(), kind, pair);
    for (std::size_t i = 0; i < 4; ++i) motion.points[i] = step.motion.at(vertices[i]);
    const ExactAnswer answer = exact_first_touch(motion, step.t_max);
    counters.degenerate += answer.degenerate ? 1 : 0;
    if (!answer.touches) continue;
    contacts.push_back(
        detail::contact_at(kind, vertices, motion.points, motion.control_points, answer.toi, answer.side));
    contacts.back().at_start = answer.reason == TouchCase::at_start;
  }
}

StageDescriptor<NarrowPhase> describe_exact() {
  return describe_stage<NarrowPhase, Exact>(
      "exact", "rational arithmetic and algebraic numbers: the judge of the others, slow", Guarantee::exact);
}

}  // namespace volccd
