#include <volccd/oracle/judge/stage_check.hpp>

#include <algorithm>

#include <fmt/format.h>

#include <volccd/core/suggest.hpp>
#include <volccd/oracle/judge/detail/stage_trials.hpp>

namespace volccd {

namespace detail {

PromiseReport& StageTrials::find(const char* promise, bool required) {
  for (PromiseReport& one : report_.promises)
    if (one.promise == promise) return one;
  report_.promises.push_back({promise, required, 0, 0, {}});
  return report_.promises.back();
}

void StageTrials::each_trial(int count,
                             const std::function<void(cases::Choices&, const std::string& where)>& body) const {
  for (int i = 0; i < count; ++i) {
    if (config.progress) config.progress(i, count);
    seed_ = config.seed + static_cast<std::uint64_t>(i);
    cases::Choices choices(seed_);
    sets_.with(set_of(seed_), [&](const char* set) { body(choices, fmt::format("seed {}, {}: ", seed_, set)); });
  }
}

void StageTrials::with_another_set(const std::function<void(const char* name)>& body) const {
  const std::size_t others = sets_.size() - 1;
  if (!config.instruction_sets || others == 0) return;
  sets_.with(set_of(seed_) + 1 + seed_ / sets_.size() % others, body);
}

void StageTrials::expect_no_allocation(const std::function<void(int k)>& step, bool required) {
  constexpr int kSteps = 2 * kWarmUp;
  if (!config.allocation_count) return;
  find(kNoAllocation, required);
  const std::size_t none = config.allocation_count();
  const auto probe = std::make_unique<int>(0);
  // volatile, so that the compiler does not remove the allocation
  int* volatile seen = probe.get();
  if (!seen || config.allocation_count() == none) return;  // the counter does not count, and is not used
  for (int k = 0; k < kSteps; ++k) {
    const std::size_t before = config.allocation_count();
    step(k);
    const std::size_t after = config.allocation_count();
    if (k >= kWarmUp)
      expect(
          kNoAllocation, after == before,
          [&] {
            return fmt::format("prepare() and run() on step {} of one topology: {} allocations", k + 1, after - before);
          },
          required);
  }
}

StepChoice choose_step(cases::Choices& choices, int max_control_points, bool separation) {
  StepChoice step;
  step.kind = choices.below(2) ? FeatureKind::ee : FeatureKind::vf;
  step.control_points = 2 + (choices.below(2) ? max_control_points - 2 : 0);
  step.separation = choices.one_in(3) && separation;
  return step;
}

double choose_t_max(cases::Choices& choices, const cases::Case& c) {
  const double any = choices.below(64) / 64.0;
  const int which = choices.below(4);
  return which == 2 && c.touch >= 0 ? c.touch : which == 3 ? any : 1;
}

cases::Case case_of(const Step& step, FeatureKind kind, FeaturePair pair) {
  cases::Case c;
  c.kind = kind;
  c.control_points = step.motion.control_points();
  c.separation = step.separation;
  const std::array<Index, 4> vertices = test_vertices(step.features(), kind, pair);
  for (std::size_t i = 0; i < 4; ++i) {
    cases::Curve p;
    for (int k = 0; k < 3; ++k)
      p[static_cast<std::size_t>(k)] = step.motion.point(vertices[i], std::min(k, c.control_points - 1));
    c.sets[i < c.own(0) ? 0 : 1].push_back(p);
  }
  return c;
}

}  // namespace detail

bool StageReport::kept() const {
  return std::all_of(promises.begin(), promises.end(), [](const PromiseReport& one) { return one.kept(); });
}

namespace {

/// Whether the stage is one of this kind; tries it if so.
template <class Kind>
bool try_kind(const Registry& registry, const std::string& name, const StageCheckConfig& config, StageReport& report) {
  for (const StageDescriptor<Kind>& descriptor : registry.stages<Kind>()) {
    if (descriptor.name != name) continue;
    report.role = Kind::kRole;
    report.guarantee = descriptor.guarantee;
    detail::StageTrials trials(config, report);
    detail::try_stage(*descriptor.make(config.options), trials);
    if (config.pipelines) detail::try_pipelines(registry, report, trials);
    return true;
  }
  return false;
}

template <class... Kinds>
bool try_kinds(const Registry& registry, const std::string& name, const StageCheckConfig& config, StageReport& report) {
  return (try_kind<Kinds>(registry, name, config, report) || ...);
}

template <class... Kinds>
std::string names(const Registry& registry) {
  std::string all;
  const auto add = [&](const auto& list) {
    for (const auto& descriptor : list) all += (all.empty() ? "" : ", ") + descriptor.name;
  };
  (add(registry.stages<Kinds>()), ...);
  return all;
}

[[noreturn]] void unknown_stage(const std::string& stage, const std::string& known) {
  throw ConfigError(fmt::format("no stage '{}'; there are {}{}", stage, known, did_you_mean(stage, known)));
}

}  // namespace

StageReport check_stage(const Registry& registry, const std::string& stage, const StageCheckConfig& config) {
  StageReport report;
  report.stage = stage;
  if (!try_kinds<BroadPhase, ElementCulling, Assignment, OrphanSource, Flood, FeatureFilter, NarrowPhase>(
          registry, stage, config, report))
    unknown_stage(stage, names<BroadPhase, ElementCulling, Assignment, OrphanSource, Flood, FeatureFilter, NarrowPhase>(
                             registry));
  return report;
}

}  // namespace volccd
