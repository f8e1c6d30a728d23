// What one of several ranks reads of a sequence.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <volccd/distributed/elements.hpp>
#include <volccd/io/sequence/stepper.hpp>

namespace volccd {

/// The steps of a sequence (SequenceStepper), of which a rank has an equal part of the cells and points. Members throw
/// the errors of reading; all ranks call them alike, but none of them is collective.
class StepSource {
 public:
  virtual ~StepSource() = default;

  /// Makes a step the current one. Returns whether the elements are others than before; the same on all ranks.
  virtual bool go_to(int step, Executor& executor) = 0;
  /// Of the current step: the elements of this rank, the ids of its vertices, their motion, the separation of a query.
  virtual distributed::Elements elements() const = 0;
  virtual std::vector<std::int64_t> vertices() const = 0;
  virtual const Motion& motion() const = 0;
  virtual double separation() const = 0;
};

/// Reads its part alone where that is enough: linear and query motion, shells as surfaces, stored objects, no
/// polyhedra. Otherwise reads all of each frame. The reader must outlive the source.
std::unique_ptr<StepSource> make_step_source(SequenceReader& reader, const SequenceStepper::Config& config, int rank,
                                             int ranks);

}  // namespace volccd
