// Stages and pipelines by name. Explicit: a registry is a value, filled by calls; nothing registers itself at start-up.
#pragma once

#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include <volccd/broadphase/broad_phase.hpp>
#include <volccd/culling/element_culling.hpp>
#include <volccd/culling/assignment.hpp>
#include <volccd/culling/feature_filter.hpp>
#include <volccd/culling/flood.hpp>
#include <volccd/culling/orphan_source.hpp>
#include <volccd/narrowphase/narrow_phase.hpp>

namespace volccd {

/// A stage by name, with the options that differ from its defaults.
struct StageChoice {
  std::string name;
  OptionValues options;
};

/// A pipeline as data: what runs, in which order.
struct PipelineSpec {
  std::string name;         ///< as typed by a user, e.g. "VolCCD"
  std::string description;  ///< one line
  StageChoice broad_phase;
  std::vector<StageChoice> element_culling;  ///< may be empty
  StageChoice assignment;
  std::optional<StageChoice> orphans;
  std::vector<StageChoice> feature_filters;  ///< may be empty
  StageChoice narrow_phase;
  std::optional<StageChoice> flood = std::nullopt;  ///< beside assignment and orphans, for the steps that it takes

  /// All stages in the order in which they run, each with its role as in `--set`.
  std::vector<std::pair<const char*, StageChoice*>> stages();
  std::vector<std::pair<const char*, const StageChoice*>> stages() const;
};

class Registry {
 public:
  /// Everything that the library has: all stages; the presets NavCCD, HashCCD, VolCCD, VolCCD+ and BruteForce;
  /// NavCCD-2011, HashCCD-2011 and VolCCD-2011.
  static Registry standard();

  /// Adds a stage. Throws ConfigError if the name is taken by any stage: `--set name.option=value` must be unambiguous.
  template <class Stage>
  void add(StageDescriptor<Stage> descriptor) {
    check_new(descriptor.name);
    std::get<Stages<Stage>>(stages_).push_back(std::move(descriptor));
  }
  /// Adds a pipeline. Throws ConfigError if the name is taken.
  void add_pipeline(PipelineSpec spec);

  /// Stage is BroadPhase, ElementCulling, Assignment, OrphanSource, Flood, FeatureFilter or NarrowPhase.
  template <class Stage>
  const std::vector<StageDescriptor<Stage>>& stages() const {
    return std::get<Stages<Stage>>(stages_);
  }
  /// Throws ConfigError that names the known ones.
  template <class Stage>
  const StageDescriptor<Stage>& stage(const std::string& name) const {
    std::string known;
    for (const StageDescriptor<Stage>& descriptor : stages<Stage>()) {
      if (descriptor.name == name) return descriptor;
      known += (known.empty() ? "" : ", ") + descriptor.name;
    }
    unknown("stage", name, known);
  }

  const std::vector<PipelineSpec>& pipelines() const { return pipelines_; }
  const PipelineSpec& pipeline(const std::string& name) const;
  /// The same with every option of its stages, defaults included. Throws ConfigError: unknown stage or option.
  PipelineSpec resolved(PipelineSpec spec) const;

  /// Changes a spec by one setting, as `--set` has it. Throws ConfigError.
  ///     stage.option=value      an option of a stage that the pipeline has:  csat.axis=optimal
  ///     role=name[,name...]     another stage in a role, or none:            feature-filter=feature-kdop,coplanarity
  /// Roles: broad-phase, element-culling, assignment, orphans, flood, feature-filter, narrow-phase. Options that a
  /// stage has stay when it is named again.
  void apply_setting(PipelineSpec& spec, const std::string& setting) const;

 private:
  template <class Stage>
  using Stages = std::vector<StageDescriptor<Stage>>;

  void check_new(const std::string& name) const;
  [[noreturn]] static void unknown(const char* what, const std::string& name, const std::string& known);

  std::tuple<Stages<BroadPhase>, Stages<ElementCulling>, Stages<Assignment>, Stages<OrphanSource>, Stages<Flood>,
             Stages<FeatureFilter>, Stages<NarrowPhase>>
      stages_;
  std::vector<PipelineSpec> pipelines_;
};

}  // namespace volccd
