// Pipelines that contain a stage, against those that do not: on colliding bodies and on further steps of the caller.
#include <algorithm>
#include <map>

#include <fmt/format.h>

#include <volccd/oracle/cases/colliding_scenes.hpp>
#include <volccd/oracle/judge/detail/stage_trials.hpp>
#include <volccd/oracle/judge/hostile_judge.hpp>
#include <volccd/pipelines/compare.hpp>
#include <volccd/pipelines/pipeline.hpp>

namespace volccd::detail {

namespace {

/// A pipeline with workspaces that are kept from step to step.
struct Entry {
  explicit Entry(const Registry& registry, const PipelineSpec& spec)
      : pipeline(registry, spec), serial(pipeline.make_workspace()), threaded(pipeline.make_workspace()) {}

  Pipeline pipeline;
  Workspace serial, threaded;
};

std::vector<PipelineSpec> specs_with(const Registry& registry, const StageReport& stage, const OptionValues& options) {
  const StageChoice choice{stage.stage, options};
  const std::string& role = stage.role;
  PipelineSpec every = registry.pipeline("NavCCD"), nonadjacent = registry.pipeline("VolCCD+");
  std::vector<PipelineSpec> specs;
  const auto add = [&](PipelineSpec& spec) {
    spec.name += " with " + stage.stage;
    specs.push_back(spec);
  };
  if (role == Assignment::kRole) {
    const auto assignment = registry.stage<Assignment>(stage.stage).make(options);
    every.assignment = nonadjacent.assignment = choice;
    if (assignment->incomplete_on_every().empty()) add(every);
    if (assignment->incomplete_on_nonadjacent().empty()) add(nonadjacent);
    return specs;
  }
  for (PipelineSpec* spec : {&every, &nonadjacent}) {
    if (role == BroadPhase::kRole) spec->broad_phase = choice;
    if (role == ElementCulling::kRole) spec->element_culling = {choice};
    if (role == FeatureFilter::kRole) spec->feature_filters = {choice};
    if (role == NarrowPhase::kRole) spec->narrow_phase = choice;
    // A narrow phase is judged by exact arithmetic, which is slow, and therefore runs behind the filters only.
    if ((role == OrphanSource::kRole || role == Flood::kRole || role == NarrowPhase::kRole) && spec == &every) continue;
    if (role == OrphanSource::kRole) {
      spec->orphans = choice;
      spec->flood.reset();  // the flood would list the orphans instead
    }
    if (role == Flood::kRole) spec->flood = choice;
    add(*spec);
  }
  return specs;
}

class PipelineTrials {
 public:
  PipelineTrials(const Registry& registry, const StageReport& stage, StageTrials& trials)
      : trials_(trials),
        is_narrow_phase_(stage.role == NarrowPhase::kRole),
        small_(registry, reference(registry, is_narrow_phase_ ? "VolCCD+" : "BruteForce")),
        large_(registry, reference(registry, is_narrow_phase_ ? "VolCCD+" : "NavCCD")) {
    for (const PipelineSpec& spec : specs_with(registry, stage, trials.config.options))
      entries_.push_back(std::make_unique<Entry>(registry, spec));
    if (!is_narrow_phase_) return;
    const auto narrow = registry.stage<NarrowPhase>(stage.stage).make(trials.config.options);
    max_control_points_ = narrow->max_control_points();
    tolerance_ = narrow->time_tolerance();
  }

  void run_generated() {
    cases::Choices choices(trials_.config.seed);
    std::vector<cases::Scene> scenes = cases::small_scenes(trials_.config.seed, 0.15);
    for (cases::Scene& scene : scenes) {
      run_scene(scene, scene.name);
      TopologyEdit edit;
      for (Index o = 0; o < scene.topology.mesh().element_slots(); ++o)
        if (choices.below(4) == 0) edit.removed.push_back(o);
      scene.topology.apply(edit);
      run_scene(scene, scene.name + ", some elements removed");
    }
  }

  void run_further_steps() {
    trials_.config.further_steps([this](const Step& step, const std::string& where) { run_step(step, where); });
  }

 private:
  static constexpr Index kBruteForceLimit = 3000;

  /// A narrow phase is compared with `exact`; with any other stage, the contacts must be those of the preset, bit for
  /// bit.
  PipelineSpec reference(const Registry& registry, const char* preset) const {
    PipelineSpec spec = registry.pipeline(preset);
    if (is_narrow_phase_) spec.narrow_phase = {"exact", {}};
    return spec;
  }

  /// Runs linear and curved motion, with a separation, between objects only, and with a part of the step.
  void run_scene(const cases::Scene& scene, const std::string& name) {
    const ObjectFilter everything, inter(PairScope::inter);
    const Topology& topology = scene.topology;
    const Motion& motion = scene.motion;
    Motion curved(motion.vertex_count(), 3);
    for (Index v = 0; v < motion.vertex_count(); ++v) {
      const Vec3 start = motion.point(v, 0), end = motion.point(v, 1);
      const Vec3 bend(0.1, 0.2, v % 3 ? -0.3 : 0.3);
      curved.set(v, 0, start);
      curved.set(v, 1, (start + end) / 2 + bend);
      curved.set(v, 2, end);
    }
    run_step({topology, motion, everything}, name);
    run_step({topology, motion, everything, 0, 0.375}, name + ", t_max 0.375");
    run_step({topology, motion, inter}, name + ", pairs of different objects");
    if (max_control_points_ > 2) run_step({topology, curved, everything}, name + ", quadratic motion");
    if (!is_narrow_phase_) run_step({topology, motion, everything, 0.05}, name + ", separation 0.05");
  }

  void run_step(const Step& step, const std::string& where) {
    Entry& reference = step.mesh().element_count() <= kBruteForceLimit ? small_ : large_;
    StepResult truth;
    const Request request{.initial_overlaps = true};
    reference.pipeline.run(step, reference.serial, trials_.serial, truth, request);
    for (const auto& entry : entries_) {
      StepResult found, by_threads, first;
      entry->pipeline.run(step, entry->serial, trials_.serial, found, request);
      entry->pipeline.run(step, entry->threaded, *trials_.threads, by_threads, request);
      entry->pipeline.run(step, entry->serial, trials_.serial, first, {.query = Query::first});
      const std::string place = where + ", " + entry->pipeline.spec().name + ": ";
      compare(step, truth, found, place);
      expect_same_first(found, first, place);
      trials_.expect(kThreadsAgree,
                     found.contacts == by_threads.contacts && found.initial_overlaps == by_threads.initial_overlaps,
                     [&] { return place + "other contacts with several threads"; });
      trials_.expect(
          kOverlapsAgree, truth.initial_overlaps == found.initial_overlaps,
          [&] {
            return place + fmt::format("{} initial overlaps, {} of the pipeline without it",
                                       found.initial_overlaps.size(), truth.initial_overlaps.size());
          },
          trials_.conservative());
    }
  }

  void compare(const Step& step, const StepResult& truth, const StepResult& found, const std::string& place) {
    if (is_narrow_phase_) return compare_times(step, truth, found, place);
    const ContactDifference difference = compare_contacts(truth.contacts, found.contacts);
    trials_.expect(
        kPipelinesAgree, difference.empty(),
        [&] {
          return place +
                 fmt::format("{} missing, {} extra, {} changed of {}", difference.missing.size(),
                             difference.extra.size(), difference.changed.size(), truth.contacts.size()) +
                 (difference.missing.empty() ? std::string() : ", missing " + text_of(step, difference.missing[0]));
        },
        trials_.conservative());
  }

  void compare_times(const Step& step, const StepResult& truth, const StepResult& found, const std::string& place) {
    using Key = std::pair<FeatureKind, std::array<Index, 4>>;
    std::map<Key, double> times;
    for (const Contact& contact : found.contacts) times[{contact.kind, contact.vertices}] = contact.toi;
    const bool may_be_early = found.statistics.undecided > 0;
    std::size_t missing = 0, wrong = 0;
    std::string example;
    for (const Contact& contact : truth.contacts) {
      const auto at = times.find({contact.kind, contact.vertices});
      const bool found_it = at != times.end();
      const bool right =
          found_it && at->second <= contact.toi && (may_be_early || contact.toi - at->second <= tolerance_);
      if (!right && example.empty()) example = text_of(step, contact);
      missing += !found_it;
      wrong += found_it && !right;
    }
    const std::size_t extra = found.contacts.size() + missing - truth.contacts.size();
    trials_.expect(
        kPipelinesAgree, missing == 0 && wrong == 0 && (extra == 0 || !trials_.exact()),
        [&] {
          return place + fmt::format("{} missing, {} extra, {} at a wrong time, of {} that `exact` finds; {}", missing,
                                     extra, wrong, truth.contacts.size(), example);
        },
        trials_.conservative());
  }

  /// Checks that Query::first gives the earliest contact of all.
  void expect_same_first(const StepResult& all, const StepResult& first, const std::string& place) {
    const auto earliest = std::min_element(all.contacts.begin(), all.contacts.end(),
                                           [](const Contact& x, const Contact& y) { return x.toi < y.toi; });
    const bool same = earliest == all.contacts.end() ? first.contacts.empty()
                                                     : first.contacts.size() == 1 && first.contacts[0] == *earliest;
    trials_.expect(
        kPipelinesAgree, same, [&] { return place + "another earliest contact if it alone is asked for"; },
        trials_.conservative());
  }

  static std::string text_of(const Step& step, const Contact& contact) {
    const auto id = [&](std::size_t i) { return step.mesh().vertex_id(contact.vertices[i]); };
    return fmt::format("{} of the vertices {} {} {} {} at t = {:g}", contact.kind == FeatureKind::vf ? "VF" : "EE",
                       id(0), id(1), id(2), id(3), contact.toi);
  }

  StageTrials& trials_;
  bool is_narrow_phase_;
  Entry small_, large_;  ///< pipelines without the stage, for meshes of few and of many elements
  std::vector<std::unique_ptr<Entry>> entries_;
  int max_control_points_ = 3;
  double tolerance_ = 0;
};

/// Pipelines with the stage and the given options, and with options by which it leaves no step to another stage.
std::vector<PipelineSpec> hostile_specs(const Registry& registry, const StageReport& stage,
                                        const OptionValues& options) {
  std::vector<PipelineSpec> specs = specs_with(registry, stage, options);
  PipelineSpec forced = stage.role == Flood::kRole ? forced_flood(registry) : forced_star_orphans(registry);
  StageChoice& choice = stage.role == Flood::kRole ? *forced.flood : *forced.orphans;
  if (choice.name != stage.stage) return specs;
  for (const auto& [name, value] : options) choice.options[name] = value;
  specs.push_back(forced);
  return specs;
}

/// Floods and orphan sources rely on vertex stars and on the topology around them, for which colliding bodies are too
/// regular.
void try_hostile_meshes(const Registry& registry, const StageReport& stage, StageTrials& trials) {
  HostileJudge judge(registry, hostile_specs(registry, stage, trials.config.options));
  const auto expect_nothing_lost = [&](const cases::HostileCase& c, const std::string& where) {
    const std::string problem = judge.judge(c);
    trials.expect(
        kPipelinesAgree, problem.empty(), [&] { return where + problem; }, trials.conservative());
  };
  for (const cases::HostileMember& member : cases::hostile_members()) expect_nothing_lost(member.make(), "");
  trials.each_trial(std::max(1, trials.config.trials / 2), [&](cases::Choices& choices, const std::string& where) {
    expect_nothing_lost(cases::make_hostile(choices), where);
  });
}

}  // namespace

void try_pipelines(const Registry& registry, const StageReport& stage, StageTrials& trials) {
  PipelineTrials pipelines(registry, stage, trials);
  pipelines.run_generated();
  if (stage.role == OrphanSource::kRole || stage.role == Flood::kRole) try_hostile_meshes(registry, stage, trials);
  if (trials.config.further_steps) pipelines.run_further_steps();
}

}  // namespace volccd::detail
