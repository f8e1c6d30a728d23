// The instruction sets of the vector kernels, to be tried one after the other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace volccd::cases {

/// The instruction sets for which the kernels are compiled and that this processor has, best first. The choice of a set
/// holds for the whole process, which is why no two threads may choose one at a time.
class InstructionSets {
 public:
  InstructionSets();

  std::size_t size() const { return targets_.size(); }
  const char* name(std::size_t i) const;

  /// Calls visit(name) while kernels use set number i (modulo size()); afterwards they use the best one again. The
  /// processor is queried only once, because a virtual machine takes 20 microseconds to answer.
  template <class Visit>
  void with(std::size_t i, Visit&& visit) const {
    i %= size();
    const Use use(*this, i);
    visit(name(i));
  }
  /// Calls visit with each set in turn.
  template <class Visit>
  void with_each(Visit&& visit) const {
    for (std::size_t i = 0; i < size(); ++i) with(i, visit);
  }

  /// Kernels use set number i < size() during the life of this object, and the set that they used before afterwards.
  class Use {
   public:
    Use(const InstructionSets& sets, std::size_t i);
    Use(const Use&) = delete;
    ~Use();

   private:
    const InstructionSets& sets_;
    std::size_t before_;
  };

 private:
  static constexpr std::size_t kBest = ~std::size_t{0};

  void choose(std::size_t i) const;

  std::int64_t supported_;
  std::vector<std::int64_t> targets_;
  mutable std::size_t chosen_ = kBest;
};

}  // namespace volccd::cases
