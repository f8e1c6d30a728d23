#include <volccd/mesh/sequence/stepper.hpp>

#include <string>
#include <utility>

#include <volccd/core/error.hpp>

namespace volccd {

void SequenceStepper::go_to(int motion) {
  if (motion < 0 || motion >= motion_count())
    throw InputError(reader_.file(), "VTKHDF/Steps", motion,
                     "there is no such motion, the file has " + std::to_string(motion_count()));
  // All that can fail comes before the first change.
  read_points(motion);
  set_topology(motion + 1);
  const Index n = reader_.point_count();
  if (motion_.vertex_count() != n) motion_ = Motion(n, 2);
  for (Index v = 0; v < n; ++v) {
    motion_.set(v, 0, x0_.positions[v]);
    motion_.set(v, 1, x1_.positions[v]);
  }
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

void SequenceStepper::set_topology(int step) {
  if (!topology_) {
    reader_.read_cells(step, cells_);
    topology_.emplace(mesh_of(reader_.point_ids(), cells_), config_.edge_set);
  } else if (!reader_.same_cells(step, topology_step_)) {
    reader_.read_cells(step, cells_);
    const TopologyEdit edit = edit_to(topology_->mesh(), cells_);
    if (!edit.empty()) topology_->apply(edit);
  }
  topology_step_ = step;
}

}  // namespace volccd
