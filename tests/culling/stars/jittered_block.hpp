// A step of a block whose vertices move at random.
#pragma once

#include <cstdint>

#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/query/step.hpp>

namespace volccd {

/// A block of n x n x n cells at rest at first; until the end of the step each vertex moves by at most `amount` along
/// each axis.
class JitteredBlock {
 public:
  JitteredBlock(ElementType type, int n, double amount, std::uint64_t seed)
      : JitteredBlock(block(type, n, n, n), amount, seed) {}
  JitteredBlock(const Shape& shape, double amount, std::uint64_t seed)
      : topology_(shape.mesh()), motion_(Motion::linear(shape.positions, jittered(shape.positions, amount, seed))) {}

  const Topology& topology() const { return topology_; }
  Step step(double separation = 0) const { return {topology_, motion_, filter_, separation}; }

 private:
  Topology topology_;
  Motion motion_;
  ObjectFilter filter_;
};

}  // namespace volccd
