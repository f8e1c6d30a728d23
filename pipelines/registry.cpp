#include <volccd/pipelines/registry.hpp>

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include <volccd/broadphase/brute_force.hpp>
#include <volccd/broadphase/kdop_bvh.hpp>
#include <volccd/broadphase/spatial_hash.hpp>
#include <volccd/core/suggest.hpp>
#include <volccd/culling/assignment/all_pairs.hpp>
#include <volccd/culling/assignment/dynamic_assignment.hpp>
#include <volccd/culling/assignment/static_assignment.hpp>
#include <volccd/culling/csat/csat.hpp>
#include <volccd/culling/element_kdop.hpp>
#include <volccd/culling/filters/coplanarity_filter.hpp>
#include <volccd/culling/filters/csat_filter.hpp>
#include <volccd/culling/filters/feature_kdop_filter.hpp>
#include <volccd/culling/flood/boundary_flood.hpp>
#include <volccd/culling/o_set/o_set_source.hpp>
#include <volccd/culling/stars/star_orphans.hpp>
#include <volccd/narrowphase/cubic/cubic.hpp>
#include <volccd/narrowphase/exact/exact.hpp>
#include <volccd/narrowphase/inclusion/inclusion.hpp>

namespace volccd {

namespace {

void add_presets(Registry& registry) {
  const StageChoice bvh{"kdop-bvh"}, all_pairs{"all-pairs"}, dynamic{"dynamic-assignment"}, inclusion{"inclusion"};
  registry.add_pipeline({.name = "NavCCD",
                         .description = "k-DOP BVH and all elementary tests of overlapping elements (Section 6.1)",
                         .broad_phase = bvh,
                         .assignment = all_pairs,
                         .narrow_phase = inclusion});
  registry.add_pipeline(
      {.name = "HashCCD",
       .description = "spatial hashing and all elementary tests of overlapping elements (Section 6.1)",
       .broad_phase = {"spatial-hash"},
       .assignment = all_pairs,
       .narrow_phase = inclusion});
  registry.add_pipeline({.name = "VolCCD",
                         .description = "the paper's: k-DOP BVH, CSAT, dynamic assignment with O-Set",
                         .broad_phase = bvh,
                         .element_culling = {{"csat", {{"axis", "face"}, {"mode", "features"}}}},
                         .assignment = dynamic,
                         .orphans = StageChoice{"o-set"},
                         .feature_filters = {{"feature-csat"}},
                         .narrow_phase = inclusion});
  registry.add_pipeline({.name = "VolCCD+",
                         .description = "the best that this project knows",
                         .broad_phase = bvh,
                         .element_culling = {{"element-kdop"}, {"csat", {{"axis", "optimal"}, {"mode", "pair"}}}},
                         .assignment = dynamic,
                         .orphans = StageChoice{"star-orphans"},
                         .feature_filters = {{"feature-kdop"}, {"coplanarity"}, {"feature-csat"}},
                         .narrow_phase = inclusion,
                         .flood = StageChoice{"boundary-flood"}});
  registry.add_pipeline(
      {.name = "BruteForce",
       .description = "every pair of elements, compared by its swept box, and all its elementary tests",
       .broad_phase = {"brute-force"},
       .assignment = all_pairs,
       .narrow_phase = inclusion});
}

/// Splits "a,b,c"; the result is empty for "" and "none".
std::vector<std::string> names_in(std::string_view list) {
  std::vector<std::string> names;
  if (list == "none") return names;
  while (!list.empty()) {
    const std::size_t comma = std::min(list.find(','), list.size());
    names.emplace_back(list.substr(0, comma));
    list.remove_prefix(std::min(comma + 1, list.size()));
  }
  return names;
}

StageChoice named(PipelineSpec& spec, const std::string& name) {
  for (const auto& [role, choice] : spec.stages())
    if (choice->name == name) return *choice;
  return {name, {}};
}

void set_option(PipelineSpec& spec, const std::string& stage, const std::string& option, const std::string& value) {
  bool found = false;
  std::string known;
  for (const auto& [role, choice] : spec.stages()) {
    known += (known.empty() ? "" : ", ") + choice->name;
    if (choice->name != stage) continue;
    choice->options[option] = value;
    found = true;
  }
  if (!found)
    throw ConfigError(
        fmt::format("pipeline {} has no stage '{}'; it has {}{}", spec.name, stage, known, did_you_mean(stage, known)));
}

void set_role(PipelineSpec& spec, const std::string& role, const std::string& value) {
  std::vector<StageChoice> stages;
  for (const std::string& name : names_in(value)) stages.push_back(named(spec, name));
  const auto one = [&](StageChoice& choice) {
    if (stages.size() != 1) throw ConfigError(fmt::format("{}: needs exactly one stage, not '{}'", role, value));
    choice = stages.front();
  };
  if (role == BroadPhase::kRole) return one(spec.broad_phase);
  if (role == ElementCulling::kRole) return spec.element_culling.swap(stages);
  if (role == Assignment::kRole) return one(spec.assignment);
  if (role == FeatureFilter::kRole) return spec.feature_filters.swap(stages);
  if (role == NarrowPhase::kRole) return one(spec.narrow_phase);
  if (role != OrphanSource::kRole && role != Flood::kRole) {
    const std::vector<std::string> known = {BroadPhase::kRole,   ElementCulling::kRole, Assignment::kRole,
                                            OrphanSource::kRole, Flood::kRole,          FeatureFilter::kRole,
                                            NarrowPhase::kRole};
    throw ConfigError(fmt::format("no role '{}'; there are {}, or stage.option=value{}", role, fmt::join(known, ", "),
                                  did_you_mean(role, known)));
  }
  std::optional<StageChoice>& choice = role == Flood::kRole ? spec.flood : spec.orphans;
  choice.reset();
  if (!stages.empty()) one(choice.emplace());
}

/// The stages of a spec, which may be const.
template <class Choice, class Spec>
std::vector<std::pair<const char*, Choice*>> stages_of(Spec& spec) {
  std::vector<std::pair<const char*, Choice*>> all = {{BroadPhase::kRole, &spec.broad_phase}};
  for (Choice& choice : spec.element_culling) all.emplace_back(ElementCulling::kRole, &choice);
  all.emplace_back(Assignment::kRole, &spec.assignment);
  if (spec.orphans) all.emplace_back(OrphanSource::kRole, &*spec.orphans);
  if (spec.flood) all.emplace_back(Flood::kRole, &*spec.flood);
  for (Choice& choice : spec.feature_filters) all.emplace_back(FeatureFilter::kRole, &choice);
  all.emplace_back(NarrowPhase::kRole, &spec.narrow_phase);
  return all;
}

}  // namespace

std::vector<std::pair<const char*, StageChoice*>> PipelineSpec::stages() { return stages_of<StageChoice>(*this); }
std::vector<std::pair<const char*, const StageChoice*>> PipelineSpec::stages() const {
  return stages_of<const StageChoice>(*this);
}

Registry Registry::standard() {
  Registry registry;
  registry.add(describe_kdop_bvh());
  registry.add(describe_spatial_hash());
  registry.add(describe_brute_force());
  registry.add(describe_element_kdop());
  registry.add(describe_csat());
  registry.add(describe_all_pairs());
  registry.add(describe_static_assignment());
  registry.add(describe_dynamic_assignment());
  registry.add(describe_o_set());
  registry.add(describe_star_orphans());
  registry.add(describe_boundary_flood());
  registry.add(describe_feature_kdop_filter());
  registry.add(describe_coplanarity_filter());
  registry.add(describe_csat_filter());
  registry.add(describe_cubic());
  registry.add(describe_inclusion());
  registry.add(describe_exact());
  add_presets(registry);
  return registry;
}

void Registry::check_new(const std::string& name) const {
  const auto named = [&](const auto& descriptor) { return descriptor.name == name; };
  if (std::apply([&](const auto&... lists) { return (std::ranges::any_of(lists, named) || ...); }, stages_))
    throw ConfigError(fmt::format("a stage '{}' is registered already", name));
}

void Registry::unknown(const char* what, const std::string& name, const std::string& known) {
  throw ConfigError(fmt::format("no {} '{}'; there are {}{}", what, name, known, did_you_mean(name, known)));
}

void Registry::add_pipeline(PipelineSpec spec) {
  for (const PipelineSpec& other : pipelines_)
    if (other.name == spec.name) throw ConfigError(fmt::format("a pipeline '{}' is registered already", spec.name));
  resolved(spec);
  pipelines_.push_back(std::move(spec));
}

PipelineSpec Registry::pipeline(const std::string& name, std::span<const std::string> settings) const {
  PipelineSpec spec = pipeline(name);
  for (const std::string& setting : settings) apply_setting(spec, setting);
  return spec;
}

PipelineSpec Registry::resolved(PipelineSpec spec) const {
  const auto fill = [](const std::vector<OptionInfo>& known, StageChoice& choice) {
    for (const OptionInfo& option : known) choice.options.try_emplace(option.name, option.default_value);
  };
  try {
    fill(stage<BroadPhase>(spec.broad_phase.name).options, spec.broad_phase);
    for (StageChoice& choice : spec.element_culling) fill(stage<ElementCulling>(choice.name).options, choice);
    fill(stage<Assignment>(spec.assignment.name).options, spec.assignment);
    if (spec.orphans) fill(stage<OrphanSource>(spec.orphans->name).options, *spec.orphans);
    if (spec.flood) fill(stage<Flood>(spec.flood->name).options, *spec.flood);
    for (StageChoice& choice : spec.feature_filters) fill(stage<FeatureFilter>(choice.name).options, choice);
    fill(stage<NarrowPhase>(spec.narrow_phase.name).options, spec.narrow_phase);
  } catch (const ConfigError& error) {
    throw ConfigError(fmt::format("pipeline {}: {}", spec.name, error.what()));
  }
  return spec;
}

void Registry::apply_setting(PipelineSpec& spec, const std::string& setting) const {
  const std::size_t equals = setting.find('=');
  if (equals == std::string::npos || equals == 0)
    throw ConfigError(fmt::format("'{}' is neither stage.option=value nor role=name[,name...]", setting));
  const std::string key = setting.substr(0, equals), value = setting.substr(equals + 1);
  const std::size_t dot = key.find('.');
  if (dot == std::string::npos)
    set_role(spec, key, value);
  else
    set_option(spec, key.substr(0, dot), key.substr(dot + 1), value);
}

}  // namespace volccd
