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
  if (config.motion == MotionModel::quadratic && reader.step_count() == 2 && !reader.has_velocity())
    throw InputError(reader.file(), "VTKHDF/PointData/Velocity",
                     "is missing: quadratic motion needs velocities, or three steps");
  if (config.motion == MotionModel::tentative && reader.step_count() > 1 && !reader.has_velocity())
    throw InputError(
        reader.file(), "VTKHDF/PointData/Velocity",
        "is missing: tentative motion needs the velocities of each step; store them, or use linear motion");
  if (config.motion == MotionModel::query && reader.step_count() > 1 && !reader.has_query())
    throw InputError(reader.file(), "VTKHDF/PointData/QueryStart",
                     "is missing: the file has no queries of a simulation. Scenes that were simulated by an earlier "
                     "version have none: remove the file from the cache, and simulate the scene again (`volccd scene "
                     "generate`), or take another motion");
  if (config.parts == PartModel::components) components_.emplace(reader);
  if (config.shells == ShellModel::solid) solids_ = std::make_unique<detail::ShellSolids>(reader);
}

SequenceStepper::~SequenceStepper() = default;

void SequenceStepper::go_to(int motion, Executor& executor) {
  if (motion < 0 || motion >= motion_count())
    throw InputError(reader_.file(), "VTKHDF/Steps", motion,
                     "there is no such motion, the file has " + std::to_string(motion_count()));
  // All operations that can fail come before the first change.
  const bool tentative = config_.motion == MotionModel::tentative, query = config_.motion == MotionModel::query;
  double separation = 0;
  if (query)
    separation = reader_.read_query(motion + 1, start_, end_);
  else
    read_points(motion);
  read_cells(cells_step(motion));
  if (config_.motion == MotionModel::quadratic) read_middle(motion);
  if (tentative) read_tentative(motion);
  const std::vector<Vec3>& x0 = query ? start_ : points_.at(motion);
  const std::vector<Vec3>& x1 = query || tentative ? end_ : points_.at(motion + 1);
  Index without_normal = 0;
  if (solids_)
    without_normal = solids_->positions(query ? motion + 1 : motion, cells_step(motion), x0, x1, solid0_, solid1_);
  set_topology(cells_step(motion), executor);
  if (solids_) {
    if (config_.motion == MotionModel::quadratic) solid_middle_points(x0, middle_, x1, solid0_, solid1_, solid_middle_);
    set_motion(solid0_, solid1_, solid_middle_);
  } else {
    set_motion(x0, x1, middle_);
  }
  without_normal_ = without_normal;
  separation_ = separation;
  current_ = motion;
}

int SequenceStepper::third_step(int motion) const {
  if (config_.motion != MotionModel::quadratic || reader_.has_velocity()) return -1;
  return motion == 0 ? 2 : motion - 1;
}

void SequenceStepper::read_points(int motion) {
  const std::array<int, 3> wanted = {motion, config_.motion == MotionModel::tentative ? -1 : motion + 1,
                                     third_step(motion)};
  const auto is_wanted = [&](int step) { return std::find(wanted.begin(), wanted.end(), step) != wanted.end(); };
  for (const int step : wanted) {
    if (step < 0 || points_.contains(step)) continue;
    std::vector<Vec3> points;
    const auto unneeded =
        std::find_if(points_.begin(), points_.end(), [&](const auto& p) { return !is_wanted(p.first); });
    if (unneeded != points_.end()) points = std::move(points_.extract(unneeded).mapped());  // for its memory
    reader_.read_points(step, points);
    points_[step] = std::move(points);
  }
}

void SequenceStepper::mark_used(int step) {
  const bool present = reader_.same_cells(step, cells_step_);
  if (!present) reader_.read_cells(step, used_cells_);
  used_.assign(reader_.point_count(), 0);
  for (const Index v : (present ? cells_ : used_cells_).connectivity) used_[v] = 1;
}

void SequenceStepper::read_middle(int motion) {
  const std::vector<Vec3>&x0 = points_.at(motion), &x1 = points_.at(motion + 1);
  const int third = third_step(motion);
  mark_used(third < 0 ? motion : third);
  middle_.resize(x0.size());
  if (third < 0) {
    reader_.read_velocity(motion, velocity_);
    const double half = 0.5 * (reader_.time(motion + 1) - reader_.time(motion));
    for (std::size_t v = 0; v < x0.size(); ++v)
      middle_[v] = used_[v] ? Vec3(x0[v] + half * velocity_[v]) : Vec3(0.5 * x0[v] + 0.5 * x1[v]);
  } else {
    const std::vector<Vec3>& x2 = points_.at(third);
    const double t0 = reader_.time(motion), t1 = reader_.time(motion + 1), t2 = reader_.time(third);
    const double to_start = (t1 - t0) / (t2 - t0), to_end = (t1 - t0) / (t2 - t1);
    // The middle of the parabola is the midpoint of x0 and x1 minus h^2/2 times the second divided difference.
    for (std::size_t v = 0; v < x0.size(); ++v) {
      middle_[v] = 0.5 * x0[v] + 0.5 * x1[v];
      if (used_[v]) middle_[v] -= 0.5 * to_start * (to_end * (x2[v] - x1[v]) - (x1[v] - x0[v]));
    }
  }
  mark_used(motion + 1);
  for (std::size_t v = 0; v < middle_.size(); ++v) {
    if (middle_[v].allFinite()) continue;
    if (used_[v]) refuse_overflow(third < 0 ? "VTKHDF/PointData/Velocity" : "VTKHDF/Points", "quadratic", motion, v);
    middle_[v] = x0[v];
  }
}

void SequenceStepper::read_tentative(int motion) {
  const std::vector<Vec3>& x0 = points_.at(motion);
  mark_used(motion);
  reader_.read_velocity(motion, velocity_);
  const double h = reader_.time(motion + 1) - reader_.time(motion);
  end_.resize(x0.size());
  for (std::size_t v = 0; v < x0.size(); ++v) {
    end_[v] = used_[v] ? Vec3(x0[v] + h * velocity_[v]) : x0[v];
    if (!end_[v].allFinite()) refuse_overflow("VTKHDF/PointData/Velocity", "tentative", motion, v);
  }
}

void SequenceStepper::refuse_overflow(const char* dataset, const char* kind, int motion, std::size_t vertex) const {
  throw InputError(reader_.file(), dataset,
                   fmt::format("the {} motion {} of point id {} overflows", kind, motion, reader_.point_ids()[vertex]));
}

void SequenceStepper::read_cells(int step) {
  if (cells_step_ < 0 || !reader_.same_cells(step, cells_step_)) {
    cells_step_ = -1;
    reader_.read_cells(step, cells_);
    if (components_) components_->assign(cells_);
    if (solids_) solids_->set_cells(cells_);
  }
  cells_step_ = step;
}

void SequenceStepper::set_topology(int step, Executor& executor) {
  const SequenceCells& cells = solids_ ? solids_->cells() : cells_;
  edit_seconds_ = 0;
  if (!topology_) {
    const std::span<const std::int64_t> ids = solids_ ? solids_->vertex_ids() : reader_.point_ids();
    topology_.emplace(mesh_of(ids, cells), executor, config_.edge_set);
  } else if (!reader_.same_cells(step, topology_step_)) {
    const TopologyEdit edit = edit_to(topology_->mesh(), cells);
    if (!edit.empty()) {
      const auto start = std::chrono::steady_clock::now();
      topology_->apply(edit);
      edit_seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }
  }
  topology_step_ = step;
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
