// Runs what is tested on each instruction set.
#pragma once

#include <cstdint>
#include <vector>

#include <hwy/targets.h>

namespace volccd::test {

/// The instruction sets that the kernels are compiled for and that this processor has, the best first. Not thread-safe.
class VectorTargets {
 public:
  std::size_t size() const { return targets_.size(); }
  const char* name(std::size_t i) const { return hwy::TargetName(targets_[i]); }

  /// Calls visit(name) while kernels take number i (modulo size()); afterwards they take the best again.
  template <class Visit>
  void with(std::size_t i, Visit&& visit) const {
    i %= size();
    if (size() > 1) take(targets_[i]);
    visit(name(i));
    if (size() > 1) take(0);
  }
  /// With each in turn.
  template <class Visit>
  void with_each(Visit&& visit) const {
    for (std::size_t i = 0; i < size(); ++i) with(i, visit);
  }

 private:
  /// 0: those of the processor.
  static void take(std::int64_t targets) {
    hwy::SetSupportedTargetsForTest(targets);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }

  /// Compiled for one only: that cannot be chosen, and need not be among those that the processor is said to have.
  static std::vector<std::int64_t> all() {
    const std::vector<std::int64_t> both = hwy::SupportedAndGeneratedTargets();
    return both.size() > 1 ? both : std::vector<std::int64_t>{HWY_STATIC_TARGET};
  }

  std::vector<std::int64_t> targets_ = all();
};

}  // namespace volccd::test
