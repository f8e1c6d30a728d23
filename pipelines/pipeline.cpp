#include <volccd/pipelines/pipeline.hpp>

#include <atomic>
#include <cmath>

#include <fmt/format.h>

#include <volccd/pipelines/detail/workspace_data.hpp>

namespace volccd {

Workspace::Workspace() = default;
Workspace::~Workspace() = default;
Workspace::Workspace(Workspace&&) noexcept = default;
Workspace& Workspace::operator=(Workspace&&) noexcept = default;

std::size_t Workspace::bytes() const {
  if (!data_) return 0;
  std::size_t sum = 0;
  for (const auto& state : data_->states) sum += state->bytes();
  for (const auto& worker : data_->workers) sum += worker->bytes();
  return sum + data_->merger.bytes();
}

namespace {

/// Names of the registered narrow phases for which `handles` is true, with default options.
template <class Predicate>
std::string narrow_phases_that(const Registry& registry, Predicate handles) {
  std::string names;
  for (const StageDescriptor<NarrowPhase>& descriptor : registry.stages<NarrowPhase>())
    if (handles(*descriptor.make({}))) names += (names.empty() ? "" : ", ") + descriptor.name;
  return names.empty() ? "none does" : "these do: " + names;
}

/// Decides whether the tests of a pipeline contain every feature pair; no other code decides this (docs/pipelines.md).
/// Returns the element pairs that the broad phase must emit so that their tests, together with those of an orphan
/// source if there is one, contain every feature pair without a common vertex that touches. Throws ConfigError, with
/// the reason, if this holds for no range, or if a flood has no orphan source for the steps that it does not accept.
PairRange required_range(const PipelineSpec& spec, const Assignment& assignment) {
  const std::string reason = spec.orphans ? assignment.incomplete_on_nonadjacent() : assignment.incomplete_on_every();
  if (!reason.empty())
    throw ConfigError(fmt::format("pipeline {}: {} would lose contacts: {}", spec.name, spec.assignment.name, reason));
  if (spec.flood && !spec.orphans)
    throw ConfigError(
        fmt::format("pipeline {}: {} needs an orphan source for the steps that it does not take; use "
                    "orphans=o-set, or flood=none",
                    spec.name, spec.flood->name));
  return spec.orphans ? PairRange::nonadjacent : PairRange::every;
}

std::uint64_t next_id() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

}  // namespace

Pipeline::Pipeline(const Registry& registry, const PipelineSpec& spec)
    : spec_(registry.resolved(spec)), id_(next_id()) {
  const auto make = [&]<class Interface>(std::unique_ptr<Interface>& stage, const StageChoice& choice) {
    const StageDescriptor<Interface>& descriptor = registry.stage<Interface>(choice.name);
    guarantee_ = weakest(guarantee_, descriptor.guarantee);
    try {
      stage = descriptor.make(choice.options);
    } catch (const ConfigError& error) {
      throw ConfigError(fmt::format("stage {}: {}", choice.name, error.what()));
    }
    stages_.push_back(stage.get());
  };
  make(broad_phase_, spec.broad_phase);
  for (const StageChoice& choice : spec.element_culling) make(element_culling_.emplace_back(), choice);
  make(assignment_, spec.assignment);
  if (spec.orphans) make(orphans_, *spec.orphans);
  if (spec.flood) make(flood_, *spec.flood);
  for (const StageChoice& choice : spec.feature_filters) make(feature_filters_.emplace_back(), choice);
  make(narrow_phase_, spec.narrow_phase);
  range_ = required_range(spec, *assignment_);
  curved_narrow_phases_ = narrow_phases_that(registry, [](const NarrowPhase& n) { return n.max_control_points() > 2; });
  separating_narrow_phases_ = narrow_phases_that(registry, [](const NarrowPhase& n) { return n.handles_separation(); });
}

bool Pipeline::uses_cut_stars() const {
  return std::ranges::any_of(stages_, [](const Stage* stage) { return stage->uses_cut_stars(); });
}

Workspace Pipeline::make_workspace() const {
  Workspace workspace;
  workspace.data_ = std::make_unique<Workspace::Data>();
  workspace.data_->pipeline = id_;
  make_states(*workspace.data_);
  return workspace;
}

void Pipeline::make_states(Workspace::Data& data) const {
  data.states.clear();
  for (const Stage* stage : stages_)
    data.states.push_back(stage == flood_.get() ? flood_->make_state_with(*broad_phase_) : stage->make_state());
  data.intact = true;
}

void Pipeline::check(const Step& step, const Workspace& workspace) const {
  if (!workspace.data_ || workspace.data_->pipeline != id_)
    throw ConfigError(
        fmt::format("pipeline {}: the workspace is not one of this pipeline; make it with make_workspace() of the "
                    "pipeline that runs",
                    spec_.name));
  check(step);
  if (step.leave_out_shell_neighbours && step.mesh().vertex_count() % 3 != 0)
    throw ConfigError(
        fmt::format("shell neighbours can be left out of thickened shells only: the mesh has {} vertices, "
                    "not three for each vertex of a shell mesh",
                    step.mesh().vertex_count()));
}

void Pipeline::check(const Step& step) const {
  if (step.motion.vertex_count() != step.mesh().vertex_count())
    throw InputError(
        "step", "motion",
        fmt::format("moves {} vertices, the mesh has {}", step.motion.vertex_count(), step.mesh().vertex_count()));
  if (const int points = step.motion.control_points(); points < 2 || points > TestBlock::kMaxControlPoints)
    throw ConfigError(
        fmt::format("motion: {} control points a vertex; there must be two (constant velocity) or three "
                    "(constant acceleration)",
                    points));
  if (step.motion.control_points() > narrow_phase_->max_control_points())
    throw ConfigError(fmt::format("narrow phase {} handles motion of degree {} at most, not {}; {}",
                                  spec_.narrow_phase.name, narrow_phase_->max_control_points() - 1,
                                  step.motion.degree(), curved_narrow_phases_));
  if (step.piece.region.low.hasNaN() || step.piece.region.high.hasNaN())
    throw ConfigError("region: a bound is not a number");
  if (!(step.separation >= 0 && std::isfinite(step.separation)))
    throw ConfigError("separation: must be finite and not negative");
  if (step.separation > 0 && !narrow_phase_->handles_separation())
    throw ConfigError(fmt::format("narrow phase {} does not handle a separation; {}", spec_.narrow_phase.name,
                                  separating_narrow_phases_));
}

}  // namespace volccd
