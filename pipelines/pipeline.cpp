#include <volccd/pipelines/pipeline.hpp>

#include <atomic>
#include <cmath>

#include <fmt/format.h>

#include <volccd/core/floating_point.hpp>
#include <volccd/pipelines/detail/checked_executor.hpp>
#include <volccd/pipelines/detail/pipeline_run.hpp>
#include <volccd/pipelines/detail/workspace_data.hpp>

namespace volccd {

Workspace::Workspace() = default;
Workspace::~Workspace() = default;
Workspace::Workspace(Workspace&&) noexcept = default;
Workspace& Workspace::operator=(Workspace&&) noexcept = default;

std::size_t Workspace::bytes() const {
  if (!data_) return 0;
  std::size_t sum = 0;
  if (data_->broad_phase) sum += data_->broad_phase->bytes();
  if (data_->feature_culling) sum += data_->feature_culling->bytes();
  for (const auto& state : data_->element_culling) sum += state ? state->bytes() : 0;
  for (const auto& worker : data_->workers) sum += worker->bytes();
  return sum;
}

namespace {

/// Names of the registered narrow phases, made with their defaults, that `handles` is true of.
template <class Predicate>
std::string narrow_phases_that(const Registry& registry, Predicate handles) {
  std::string names;
  for (const StageDescriptor<NarrowPhase>& descriptor : registry.stages<NarrowPhase>())
    if (handles(*descriptor.make({}))) names += (names.empty() ? "" : ", ") + descriptor.name;
  return names.empty() ? "none does" : "these do: " + names;
}

/// Makes the stage and folds its guarantee into the pipeline's.
template <class Stage>
std::unique_ptr<Stage> make_stage(const Registry& registry, const StageChoice& choice, Guarantee& guarantee) {
  const StageDescriptor<Stage>& descriptor = registry.stage<Stage>(choice.name);
  guarantee = weakest(guarantee, descriptor.guarantee);
  try {
    return descriptor.make(choice.options);
  } catch (const ConfigError& error) {
    throw ConfigError(fmt::format("stage {}: {}", choice.name, error.what()));
  }
}

std::uint64_t next_id() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

}  // namespace

Pipeline::Pipeline(const Registry& registry, const PipelineSpec& spec) : spec_(spec), id_(next_id()) {
  broad_phase_ = make_stage<BroadPhase>(registry, spec.broad_phase, guarantee_);
  for (const StageChoice& choice : spec.element_culling)
    element_culling_.push_back(make_stage<ElementCulling>(registry, choice, guarantee_));
  feature_culling_ = make_stage<FeatureCulling>(registry, spec.feature_culling, guarantee_);
  for (const StageChoice& choice : spec.feature_filters)
    feature_filters_.push_back(make_stage<FeatureFilter>(registry, choice, guarantee_));
  narrow_phase_ = make_stage<NarrowPhase>(registry, spec.narrow_phase, guarantee_);
  curved_narrow_phases_ = narrow_phases_that(registry, [](const NarrowPhase& n) { return n.max_control_points() > 2; });
  separating_narrow_phases_ = narrow_phases_that(registry, [](const NarrowPhase& n) { return n.handles_separation(); });
  if (const std::string reason = feature_culling_->unsound(); !reason.empty())
    throw ConfigError(fmt::format("pipeline {}: {} would lose contacts: {}", spec.name, spec.feature_culling.name, reason));
}

Workspace Pipeline::make_workspace() const {
  Workspace workspace;
  workspace.data_ = std::make_unique<Workspace::Data>();
  workspace.data_->pipeline = id_;
  make_states(*workspace.data_);
  return workspace;
}

void Pipeline::make_states(Workspace::Data& data) const {
  data.broad_phase = broad_phase_->make_state();
  data.feature_culling = feature_culling_->make_state();
  data.element_culling.clear();
  for (const auto& stage : element_culling_) data.element_culling.push_back(stage->make_state());
  data.intact = true;
}

void Pipeline::run(const Step& step, Workspace& workspace, Executor& executor, StepResult& result,
                   const Request& request) const {
  require_standard_floating_point();
  if (!workspace.data_ || workspace.data_->pipeline != id_)
    throw ConfigError(
        fmt::format("pipeline {}: the workspace is not one of this pipeline; make it with make_workspace() of the "
                    "pipeline that runs",
                    spec_.name));
  if (step.motion.vertex_count() != step.mesh().vertex_count())
    throw InputError("step", "motion", fmt::format("moves {} vertices, the mesh has {}", step.motion.vertex_count(),
                                                   step.mesh().vertex_count()));
  if (step.motion.control_points() > narrow_phase_->max_control_points())
    throw ConfigError(fmt::format("narrow phase {} handles motion of degree {} at most, not {}; {}",
                                  spec_.narrow_phase.name, narrow_phase_->max_control_points() - 1,
                                  step.motion.degree(), curved_narrow_phases_));
  if (!(step.separation >= 0 && std::isfinite(step.separation)))
    throw ConfigError("separation: must be finite and not negative");
  if (step.separation > 0 && !narrow_phase_->handles_separation())
    throw ConfigError(fmt::format("narrow phase {} does not handle a separation; {}", spec_.narrow_phase.name,
                                  separating_narrow_phases_));
  Workspace::Data& data = *workspace.data_;
  if (!data.intact) make_states(data);
  data.intact = false;
  detail::CheckedExecutor checked(executor);
  Run(*this, step, data, checked, request).execute(result, workspace);
  data.intact = true;
}

}  // namespace volccd
