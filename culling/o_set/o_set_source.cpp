#include <volccd/culling/o_set/o_set_source.hpp>

namespace volccd {

namespace {

struct OSetState final : StageState {
  explicit OSetState(OSetKind kind) : set(kind) {}
  std::size_t bytes() const override { return set.bytes(); }

  OSet set;
};

}  // namespace

const Options<OSetSource::Config>& OSetSource::options() {
  static const Options<Config> options =
      Options<Config>().add("kind", &Config::kind, {{"minimal", OSetKind::minimal}, {"literal", OSetKind::literal}},
                            "pairs that no pair of non-adjacent elements covers, or all that Algorithm 3 keeps");
  return options;
}

std::unique_ptr<StageState> OSetSource::make_state() const { return std::make_unique<OSetState>(config_.kind); }

void OSetSource::prepare(const Step& step, StageState& state, Executor& executor) const {
  static_cast<OSetState&>(state).set.update(step.topology, executor, step.leave_out_shell_neighbours);
}

std::size_t OSetSource::blocks(const StageState& state) const {
  return static_cast<const OSetState&>(state).set.blocks();
}

void OSetSource::run(const Step&, StageState& state, unsigned, std::size_t block, Work& out) const {
  static_cast<const OSetState&>(state).set.append(block, out.tests);
}

StageDescriptor<OrphanSource> describe_o_set() {
  return describe_stage<OrphanSource, OSetSource>(
      "o-set", "the feature pairs that no pair of non-adjacent elements covers (Section 5.1)", Guarantee::exact);
}

}  // namespace volccd
