#include <volccd/program/volccd_mpi/step_source.hpp>

#include <volccd/distributed/parts.hpp>

namespace volccd {

namespace {

using distributed::part_of;
using distributed::PartRange;

/// Reads all, and gives a part.
class WholeSource final : public StepSource {
 public:
  WholeSource(SequenceReader& reader, const SequenceStepper::Config& config, int rank, int ranks)
      : stepper_(reader, config), rank_(rank), ranks_(ranks) {}

  bool go_to(int step, Executor& executor) override {
    stepper_.go_to(step, executor);
    distributed::copy_motion(stepper_.motion(), part_of(mesh().vertex_count(), rank_, ranks_), motion_);
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

/// Reads its rows of points and cells. Of the others it knows the ids of the points.
class PartSource final : public StepSource {
 public:
  PartSource(SequenceReader& reader, MotionModel motion, int rank, int ranks)
      : reader_(reader),
        model_(motion),
        rank_(rank),
        ranks_(ranks),
        points_(part_of(reader.point_count(), rank, ranks)) {}

  bool go_to(int step, Executor&) override {
    separation_ = 0;
    if (model_ == MotionModel::query) {
      separation_ = reader_.read_query(step + 1, points_.begin, points_.size(), x0_, x1_);
    } else {
      if (step == frame_ && frame_ > 0)
        std::swap(x0_, x1_);
      else
        reader_.read_points(step, points_.begin, points_.size(), x0_);
      reader_.read_points(step + 1, points_.begin, points_.size(), x1_);
    }
    motion_.set_linear(x0_, x1_);
    const bool changed = frame_ < 0 || !reader_.same_cells(step + 1, frame_);
    if (changed) {
      const PartRange part = part_of(reader_.cell_count(step + 1), rank_, ranks_);
      reader_.read_cells(step + 1, part.begin, part.size(), cells_);
    }
    frame_ = step + 1;
    return changed;
  }

  distributed::Elements elements() const override {
    const std::span<const std::int64_t> ids = reader_.point_ids();
    distributed::Elements elements;
    std::vector<std::int64_t> vertices, faces;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      vertices.clear();
      faces.clear();
      for (const Index v : cells_.vertices(i)) vertices.push_back(ids[v]);
      Index rest = 0;  // of the present face
      for (const Index v : cells_.face_stream(i)) {
        faces.push_back(rest == 0 ? std::int64_t{v} : ids[v]);
        rest = rest == 0 ? v : rest - 1;
      }
      elements.add(cells_.types[i], vertices, cells_.objects[i], cells_.ids[i], faces);
    }
    return elements;
  }
  std::vector<std::int64_t> vertices() const override {
    std::vector<std::int64_t> ids;
    for (Index row = points_.begin; row < points_.end; ++row)
      ids.push_back(reader_.point_ids()[reader_.slot_of_point()[row]]);
    return ids;
  }
  const Motion& motion() const override { return motion_; }
  double separation() const override { return separation_; }

 private:
  SequenceReader& reader_;
  MotionModel model_;
  int rank_, ranks_;
  PartRange points_;
  int frame_ = -1;  ///< of cells_ and, but for a query, x1_
  SequenceCells cells_;
  std::vector<Vec3> x0_, x1_;
  Motion motion_;
  double separation_ = 0;
};

}  // namespace

std::unique_ptr<StepSource> make_step_source(SequenceReader& reader, const SequenceStepper::Config& config, int rank,
                                             int ranks) {
  const bool straight =
      config.motion == MotionModel::linear || (config.motion == MotionModel::query && reader.has_query());
  if (straight && config.shells == ShellModel::surface && config.objects == ObjectModel::stored &&
      reader.can_read_parts())
    return std::make_unique<PartSource>(reader, config.motion, rank, ranks);
  return std::make_unique<WholeSource>(reader, config, rank, ranks);
}

}  // namespace volccd
