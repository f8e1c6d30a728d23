// Runs tests on each instruction set.
#pragma once

#include <cstdint>
#include <vector>

#include <hwy/targets.h>

namespace volccd::test {

/// The instruction sets for which the kernels are compiled and that this processor has, best first. Not thread-safe.
class VectorTargets {
 public:
  std::size_t size() const { return targets_.size(); }
  const char* name(std::size_t i) const { return hwy::TargetName(targets_[i]); }

  /// Calls visit(name) while kernels use set number i (modulo size()); afterwards they use the best one again. The
  /// processor is queried only once, because a virtual machine takes 20 microseconds to answer.
  template <class Visit>
  void with(std::size_t i, Visit&& visit) const {
    i %= size();
    if (size() > 1) take(targets_[i], targets_[i]);
    visit(name(i));
    if (size() > 1) take(0, supported_);
  }
  /// Calls visit with each set in turn.
  template <class Visit>
  void with_each(Visit&& visit) const {
    for (std::size_t i = 0; i < size(); ++i) with(i, visit);
  }

 private:
  /// `mocked` 0: the sets of the processor.
  static void take(std::int64_t mocked, std::int64_t targets) {
    hwy::SetSupportedTargetsForTest(mocked);
    hwy::GetChosenTarget().Update(targets);
  }

  /// If kernels are compiled for one set only, no set can be chosen, and it need not be among those of the processor.
  static std::vector<std::int64_t> all() {
    const std::vector<std::int64_t> both = hwy::SupportedAndGeneratedTargets();
    return both.size() > 1 ? both : std::vector<std::int64_t>{HWY_STATIC_TARGET};
  }

  std::int64_t supported_ = hwy::SupportedTargets();
  std::vector<std::int64_t> targets_ = all();
};

}  // namespace volccd::test
