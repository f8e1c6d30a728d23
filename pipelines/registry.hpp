// Stages and pipelines by name. A registry is a value that is filled by explicit calls; nothing registers itself at
// start-up.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include <volccd/query/roles/assignment.hpp>
#include <volccd/query/roles/broad_phase.hpp>
#include <volccd/query/roles/element_culling.hpp>
#include <volccd/query/roles/feature_filter.hpp>
#include <volccd/query/roles/flood.hpp>
#include <volccd/query/roles/narrow_phase.hpp>
#include <volccd/query/roles/orphan_source.hpp>

namespace volccd {

/// A stage by name, with the options that differ from their defaults.
struct StageChoice {
  std::string name = {};
  OptionValues options = {};
};

/// A pipeline as data: its stages, by role.
struct PipelineSpec {
  std::string name = {};         ///< as users type it, e.g. "VolCCD"
  std::string description = {};  ///< one line
  StageChoice broad_phase = {};
  std::vector<StageChoice> element_culling = {};  ///< may be empty
  StageChoice assignment = {};
  std::optional<StageChoice> orphans = std::nullopt;
  std::vector<StageChoice> feature_filters = {};  ///< may be empty
  StageChoice narrow_phase = {};
  std::optional<StageChoice> flood = std::nullopt;  ///< the only source in the steps that it takes

  /// All stages in the order in which they run, each with its role as used by `--set`.
  std::vector<std::pair<const char*, StageChoice*>> stages();
  std::vector<std::pair<const char*, const StageChoice*>> stages() const;
};

class Registry {
 public:
  /// All stages of the library, and the presets NavCCD, HashCCD, VolCCD, VolCCD+ and BruteForce.
  static Registry standard();

  /// Adds a stage. Throws ConfigError if any other stage has this name, since `--set name.option=value` must be
  /// unambiguous.
  template <class Stage>
  void add(StageDescriptor<Stage> descriptor) {
    check_new(descriptor.name);
    std::get<Stages<Stage>>(stages_).push_back(std::move(descriptor));
  }
  /// Adds a pipeline. Throws ConfigError if another pipeline has this name, or if one of its stages is not registered.
  void add_pipeline(PipelineSpec spec);

  /// The registered stages of one role. Stage is BroadPhase, ElementCulling, Assignment, OrphanSource, Flood,
  /// FeatureFilter or NarrowPhase.
  template <class Stage>
  const std::vector<StageDescriptor<Stage>>& stages() const {
    return std::get<Stages<Stage>>(stages_);
  }
  /// The stage with this name. Throws ConfigError, listing the known names, if there is none.
  template <class Stage>
  const StageDescriptor<Stage>& stage(const std::string& name) const {
    return find("stage", stages<Stage>(), name);
  }

  const std::vector<PipelineSpec>& pipelines() const { return pipelines_; }
  const PipelineSpec& pipeline(const std::string& name) const { return find("pipeline", pipelines_, name); }
  /// The pipeline with this name, changed by the settings in their order (apply_setting). Throws ConfigError.
  PipelineSpec pipeline(const std::string& name, std::span<const std::string> settings) const;
  /// The same specification with every option of its stages, including defaults. Throws ConfigError, with the
  /// names of pipeline and stage, for an unknown stage.
  PipelineSpec resolved(PipelineSpec spec) const;

  /// Changes a spec by one setting in the syntax of `--set`. Throws ConfigError.
  ///     stage.option=value      an option of a stage that the pipeline has:  csat.axis=optimal
  ///     role=name[,name...]     another stage in a role, or none:            feature-filter=feature-kdop,coplanarity
  /// Roles: broad-phase, element-culling, assignment, orphans, flood, feature-filter, narrow-phase. A stage that is
  /// named again keeps its options.
  void apply_setting(PipelineSpec& spec, const std::string& setting) const;

 private:
  template <class Stage>
  using Stages = std::vector<StageDescriptor<Stage>>;

  template <class Entry>
  static const Entry& find(const char* what, const std::vector<Entry>& entries, const std::string& name) {
    std::string known;
    for (const Entry& entry : entries) {
      if (entry.name == name) return entry;
      known += (known.empty() ? "" : ", ") + entry.name;
    }
    unknown(what, name, known);
  }
  void check_new(const std::string& name) const;
  [[noreturn]] static void unknown(const char* what, const std::string& name, const std::string& known);

  std::tuple<Stages<BroadPhase>, Stages<ElementCulling>, Stages<Assignment>, Stages<OrphanSource>, Stages<Flood>,
             Stages<FeatureFilter>, Stages<NarrowPhase>>
      stages_;
  std::vector<PipelineSpec> pipelines_;
};

}  // namespace volccd
