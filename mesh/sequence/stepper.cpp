#include <volccd/mesh/sequence/stepper.hpp>

#include <string>
#include <utility>

#include <volccd/core/error.hpp>
#include <volccd/mesh/sequence/detail/shell_solids.hpp>

namespace volccd {

SequenceStepper::SequenceStepper(SequenceReader& reader, Config config) : reader_(reader), config_(config) {
  if (config.shells == ShellModel::solid) solids_ = std::make_unique<detail::ShellSolids>(reader);
}

SequenceStepper::~SequenceStepper() = default;

void SequenceStepper::go_to(int motion) {
  if (motion < 0 || motion >= motion_count())
    throw InputError(reader_.file(), "VTKHDF/Steps", motion,
                     "there is no such motion, the file has " + std::to_string(motion_count()));
  // All that can fail comes before the first change.
  read_points(motion);
  read_cells(motion + 1);
  Index without_normal = 0;
  if (solids_) without_normal = solids_->positions(x0_.positions, x1_.positions, solid0_, solid1_);
  set_topology(motion + 1);
  if (solids_)
    set_motion(solid0_, solid1_);
  else
    set_motion(x0_.positions, x1_.positions);
  without_normal_ = without_normal;
  current_ = motion;
}

void SequenceStepper::read_points(int motion) {
  if (x1_.step == motion || x0_.step == motion + 1) std::swap(x0_, x1_);
  read_points(motion, x0_);
  read_points(motion + 1, x1_);
}

void SequenceStepper::read_points(int step, Points& points) {
  if (points.step == step) return;
  points.step = -1;
  reader_.read_points(step, points.positions);
  points.step = step;
}

void SequenceStepper::read_cells(int step) {
  if (cells_step_ < 0 || !reader_.same_cells(step, cells_step_)) {
    cells_step_ = -1;
    reader_.read_cells(step, cells_);
    if (solids_) solids_->set_cells(cells_);
  }
  cells_step_ = step;
  if (solids_) solids_->set_step(step);
}

void SequenceStepper::set_topology(int step) {
  const SequenceCells& cells = solids_ ? solids_->cells() : cells_;
  if (!topology_) {
    const std::span<const std::int64_t> ids = solids_ ? solids_->vertex_ids() : reader_.point_ids();
    topology_.emplace(mesh_of(ids, cells), config_.edge_set);
  } else if (!reader_.same_cells(step, topology_step_)) {
    const TopologyEdit edit = edit_to(topology_->mesh(), cells);
    if (!edit.empty()) topology_->apply(edit);
  }
  topology_step_ = step;
}

void SequenceStepper::set_motion(const std::vector<Vec3>& x0, const std::vector<Vec3>& x1) {
  const Index n = static_cast<Index>(x0.size());
  if (motion_.vertex_count() != n) motion_ = Motion(n, 2);
  for (Index v = 0; v < n; ++v) {
    motion_.set(v, 0, x0[v]);
    motion_.set(v, 1, x1[v]);
  }
}

}  // namespace volccd
