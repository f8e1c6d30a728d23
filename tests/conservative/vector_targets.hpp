// Runs what is tested on each instruction set.
#pragma once

#include <vector>

#include <hwy/targets.h>

namespace volccd::test {

/// Calls visit(name) once for each instruction set that the kernels are compiled for and that this processor has, the best
/// first; kernels take the best again afterwards. Not thread-safe.
template <class Visit>
void for_each_vector_target(Visit&& visit) {
  const auto take = [](std::int64_t targets) {
    hwy::SetSupportedTargetsForTest(targets);  // 0: those of the processor
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  };
  const std::vector<std::int64_t> targets = hwy::SupportedAndGeneratedTargets();
  // Compiled for one only: it cannot be chosen, and need not be among what the processor reports.
  if (targets.size() < 2) return visit(hwy::TargetName(HWY_TARGETS));
  for (const std::int64_t target : targets) {
    take(target);
    visit(hwy::TargetName(target));
  }
  take(0);
}

}  // namespace volccd::test
