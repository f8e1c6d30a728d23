#include <volccd/program/volccd_mpi/step_source.hpp>

#include <volccd/distributed/parts.hpp>

namespace volccd {

namespace {

using distributed::PartRange;
using distributed::part_of;

/// Reads all, and gives a part.
class WholeSource final : public StepSource {
 public:
  WholeSource(SequenceReader& reader, const SequenceStepper::Config& config, int rank, int ranks)
      : stepper_(reader, config), rank_(rank), ranks_(ranks) {}

  bool go_to(int step, Executor& executor) override {
    stepper_.go_to(step, executor);
    take_part(stepper_.motion(), part_of(mesh().vertex_count(), rank_, ranks_), motion_);
    return std::exchange(version_, stepper_.topology().version()) != version_;
  }
  distributed::Elements elements() const override {
    return elements_in(mesh(), part_of(mesh().element_slots(), rank_, ranks_));
  }
  std::vector<std::int64_t> vertices() const override {
    const PartRange part = part_of(mesh().vertex_count(), rank_, ranks_);
    const auto ids = mesh().vertex_ids().subspan(part.begin, part.size());
    return {ids.begin(), ids.end()};
  }
  const Motion& motion() const override { return motion_; }
  double separation() const override { return stepper_.separation(); }

 private:
  const Mesh& mesh() const { return stepper_.topology().mesh(); }

  SequenceStepper stepper_;
  int rank_, ranks_;
  std::uint64_t version_ = 0;
  Motion motion_;
};

}  // namespace

std::unique_ptr<StepSource> make_step_source(SequenceReader& reader, const SequenceStepper::Config& config, int rank,
                                             int ranks) {
  return std::make_unique<WholeSource>(reader, config, rank, ranks);
}

}  // namespace volccd
