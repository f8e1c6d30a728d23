#include <volccd/oracle/cases/instruction_sets.hpp>

#include <hwy/targets.h>

namespace volccd::cases {

namespace {

/// If kernels are compiled for one set only, no set can be chosen, and it need not be among those of the processor.
std::vector<std::int64_t> all_targets() {
  const std::vector<std::int64_t> both = hwy::SupportedAndGeneratedTargets();
  return both.size() > 1 ? both : std::vector<std::int64_t>{HWY_STATIC_TARGET};
}

}  // namespace

InstructionSets::InstructionSets() : supported_(hwy::SupportedTargets()), targets_(all_targets()) {}

const char* InstructionSets::name(std::size_t i) const { return hwy::TargetName(targets_[i]); }

/// `kBest`: the sets of the processor.
void InstructionSets::choose(std::size_t i) const {
  chosen_ = i;
  if (size() == 1) return;
  hwy::SetSupportedTargetsForTest(i == kBest ? 0 : targets_[i]);
  hwy::GetChosenTarget().Update(i == kBest ? supported_ : targets_[i]);
}

InstructionSets::Use::Use(const InstructionSets& sets, std::size_t i) : sets_(sets), before_(sets.chosen_) {
  sets.choose(i);
}
InstructionSets::Use::~Use() { sets_.choose(before_); }

}  // namespace volccd::cases
