#include <volccd/io/sequence/stepper.hpp>

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/io/sequence/detail/shell_solids.hpp>
#include <volccd/mesh/shells.hpp>

namespace volccd {

SequenceStepper::SequenceStepper(SequenceReader& reader, Config config) : reader_(reader), config_(config) {
  if (config.motion == MotionModel::quadratic && reader.frame_count() == 2 && !reader.has_velocity())
    throw InputError(reader.file(), "VTKHDF/PointData/Velocity",
                     "is missing: quadratic motion needs velocities, or three frames");
  if (config.motion == MotionModel::tentative && reader.frame_count() > 1 && !reader.has_velocity())
    throw InputError(
        reader.file(), "VTKHDF/PointData/Velocity",
        "is missing: tentative motion needs the velocities of each frame; store them, or use linear motion");
  if (config.motion == MotionModel::query && reader.frame_count() > 1 && !reader.has_query())
    throw InputError(reader.file(), "VTKHDF/PointData/QueryStart",
                     "is missing: the file has no queries of a simulation. Scenes that were simulated by an earlier "
                     "version have none: remove the file from the cache, and simulate the scene again (`volccd scene "
                     "generate`), or take another motion");
  if (config.objects == ObjectModel::components) components_.emplace(reader);
  if (config.shells == ShellModel::solid) solids_ = std::make_unique<detail::ShellSolids>(reader);
}

SequenceStepper::~SequenceStepper() = default;

void SequenceStepper::go_to(int step, Executor& executor) {
  if (step < 0 || step >= step_count())
    throw InputError(reader_.file(), "VTKHDF/Steps", step,
                     "there is no such step, the file has " + std::to_string(step_count()));
  // All operations that can fail come before the first change.
  const bool tentative = config_.motion == MotionModel::tentative, query = config_.motion == MotionModel::query;
  double separation = 0;
  if (query)
    separation = reader_.read_query(step + 1, start_, end_);
  else
    read_points(step);
  read_cells(cells_frame(step));
  if (config_.motion == MotionModel::quadratic) read_middle(step);
  if (tentative) read_tentative(step);
  const std::vector<Vec3>& x0 = query ? start_ : points_.at(step);
  const std::vector<Vec3>& x1 = query || tentative ? end_ : points_.at(step + 1);
  Index without_normal = 0;
  if (solids_)
    without_normal = solids_->positions(query ? step + 1 : step, cells_frame(step), x0, x1, solid0_, solid1_);
  set_topology(cells_frame(step), executor);
  if (solids_) {
    if (config_.motion == MotionModel::quadratic) solid_middle_points(x0, middle_, x1, solid0_, solid1_, solid_middle_);
    set_motion(solid0_, solid1_, solid_middle_);
  } else {
    set_motion(x0, x1, middle_);
  }
  without_normal_ = without_normal;
  separation_ = separation;
  current_ = step;
}

int SequenceStepper::third_frame(int step) const {
  if (config_.motion != MotionModel::quadratic || reader_.has_velocity()) return -1;
  return step == 0 ? 2 : step - 1;
}

void SequenceStepper::read_points(int step) {
  const std::array<int, 3> wanted = {step, config_.motion == MotionModel::tentative ? -1 : step + 1, third_frame(step)};
  const auto is_wanted = [&](int frame) { return std::find(wanted.begin(), wanted.end(), frame) != wanted.end(); };
  for (const int frame : wanted) {
    if (frame < 0 || points_.contains(frame)) continue;
    std::vector<Vec3> points;
    const auto unneeded =
        std::find_if(points_.begin(), points_.end(), [&](const auto& p) { return !is_wanted(p.first); });
    if (unneeded != points_.end()) points = std::move(points_.extract(unneeded).mapped());  // for its memory
    reader_.read_points(frame, points);
    points_[frame] = std::move(points);
  }
}

void SequenceStepper::mark_used(int frame) {
  const bool present = reader_.same_cells(frame, cells_frame_);
  if (!present) reader_.read_cells(frame, used_cells_);
  used_.assign(reader_.point_count(), 0);
  for (const Index v : (present ? cells_ : used_cells_).connectivity) used_[v] = 1;
}

void SequenceStepper::read_middle(int step) {
  const std::vector<Vec3>&x0 = points_.at(step), &x1 = points_.at(step + 1);
  const int third = third_frame(step);
  mark_used(third < 0 ? step : third);
  middle_.resize(x0.size());
  if (third < 0) {
    reader_.read_velocity(step, velocity_);
    const double half = 0.5 * (reader_.time(step + 1) - reader_.time(step));
    for (std::size_t v = 0; v < x0.size(); ++v)
      middle_[v] = used_[v] ? Vec3(x0[v] + half * velocity_[v]) : Vec3(0.5 * x0[v] + 0.5 * x1[v]);
  } else {
    const std::vector<Vec3>& x2 = points_.at(third);
    const double t0 = reader_.time(step), t1 = reader_.time(step + 1), t2 = reader_.time(third);
    const double to_start = (t1 - t0) / (t2 - t0), to_end = (t1 - t0) / (t2 - t1);
    // The middle of the parabola is the midpoint of x0 and x1 minus h^2/2 times the second divided difference.
    for (std::size_t v = 0; v < x0.size(); ++v) {
      middle_[v] = 0.5 * x0[v] + 0.5 * x1[v];
      if (used_[v]) middle_[v] -= 0.5 * to_start * (to_end * (x2[v] - x1[v]) - (x1[v] - x0[v]));
    }
  }
  mark_used(step + 1);
  for (std::size_t v = 0; v < middle_.size(); ++v) {
    if (middle_[v].allFinite()) continue;
    if (used_[v]) refuse_overflow(third < 0 ? "VTKHDF/PointData/Velocity" : "VTKHDF/Points", "quadratic", step, v);
    middle_[v] = x0[v];
  }
}

void SequenceStepper::read_tentative(int step) {
  const std::vector<Vec3>& x0 = points_.at(step);
  mark_used(step);
  reader_.read_velocity(step, velocity_);
  const double h = reader_.time(step + 1) - reader_.time(step);
  end_.resize(x0.size());
  for (std::size_t v = 0; v < x0.size(); ++v) {
    end_[v] = used_[v] ? Vec3(x0[v] + h * velocity_[v]) : x0[v];
    if (!end_[v].allFinite()) refuse_overflow("VTKHDF/PointData/Velocity", "tentative", step, v);
  }
}

void SequenceStepper::refuse_overflow(const char* dataset, const char* kind, int step, std::size_t vertex) const {
  throw InputError(
      reader_.file(), dataset,
      fmt::format("the {} motion of point id {} overflows in step {}", kind, reader_.point_ids()[vertex], step));
}

void SequenceStepper::read_cells(int frame) {
  if (cells_frame_ < 0 || !reader_.same_cells(frame, cells_frame_)) {
    cells_frame_ = -1;
    reader_.read_cells(frame, cells_);
    if (components_) components_->assign(cells_);
    if (solids_) solids_->set_cells(cells_);
  }
  cells_frame_ = frame;
}

void SequenceStepper::set_topology(int frame, Executor& executor) {
  const SequenceCells& cells = solids_ ? solids_->cells() : cells_;
  edit_seconds_ = 0;
  if (!topology_) {
    const std::span<const std::int64_t> ids = solids_ ? solids_->vertex_ids() : reader_.point_ids();
    topology_.emplace(mesh_of(ids, cells), executor, config_.edge_set);
  } else if (!reader_.same_cells(frame, topology_frame_)) {
    const TopologyEdit edit = edit_to(topology_->mesh(), cells);
    if (!edit.empty()) {
      const auto start = std::chrono::steady_clock::now();
      topology_->apply(edit);
      edit_seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }
  }
  topology_frame_ = frame;
}

void SequenceStepper::set_motion(const std::vector<Vec3>& x0, const std::vector<Vec3>& x1,
                                 const std::vector<Vec3>& middle) {
  const Index n = static_cast<Index>(x0.size());
  const int last = config_.motion == MotionModel::quadratic ? 2 : 1;
  if (motion_.vertex_count() != n || motion_.degree() != last) motion_ = Motion(n, last + 1);
  for (Index v = 0; v < n; ++v) {
    motion_.set(v, 0, x0[v]);
    if (last == 2) motion_.set(v, 1, middle[v]);
    motion_.set(v, last, x1[v]);
  }
}

}  // namespace volccd
