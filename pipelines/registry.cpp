#include <volccd/pipelines/registry.hpp>

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include <volccd/broadphase/brute_force.hpp>
#include <volccd/broadphase/kdop_bvh.hpp>
#include <volccd/broadphase/spatial_hash.hpp>
#include <volccd/culling/all_pairs.hpp>
#include <volccd/culling/coplanarity_filter.hpp>
#include <volccd/culling/csat.hpp>
#include <volccd/culling/csat_filter.hpp>
#include <volccd/culling/dynamic_assignment.hpp>
#include <volccd/culling/feature_kdop_filter.hpp>
#include <volccd/culling/static_assignment.hpp>
#include <volccd/narrowphase/cubic.hpp>
#include <volccd/narrowphase/exact.hpp>
#include <volccd/narrowphase/inclusion.hpp>

namespace volccd {

namespace {

void add_presets(Registry& registry) {
  registry.add_pipeline({"NavCCD", "k-DOP BVH and all elementary tests of overlapping elements (Section 6.1)",
                         {"kdop-bvh", {}}, {}, {"all-pairs", {}}, {}, {"inclusion", {}}});
  registry.add_pipeline({"HashCCD", "spatial hashing and all elementary tests of overlapping elements (Section 6.1)",
                         {"spatial-hash", {}}, {}, {"all-pairs", {}}, {}, {"inclusion", {}}});
  registry.add_pipeline({"VolCCD", "the paper's: k-DOP BVH, CSAT, dynamic assignment with O-Set",
                         {"kdop-bvh", {}},
                         {{"csat", {{"axis", "face"}, {"mode", "features"}}}},
                         {"dynamic-assignment", {{"oset", "minimal"}}},
                         {{"feature-csat", {}}},
                         {"inclusion", {}}});
  registry.add_pipeline({"VolCCD+", "the best that this project knows",
                         {"kdop-bvh", {}},
                         {{"csat", {{"axis", "optimal"}, {"mode", "pair"}}}},
                         {"dynamic-assignment", {{"oset", "minimal"}}},
                         {{"feature-kdop", {}}, {"coplanarity", {}}, {"feature-csat", {}}},
                         {"inclusion", {}}});
  registry.add_pipeline({"BruteForce", "every pair of elements, compared by its swept box, and all its elementary tests",
                         {"brute-force", {}}, {}, {"all-pairs", {}}, {}, {"inclusion", {}}});
}

/// Splits "a,b,c"; "" and "none" give nothing.
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

/// All stage choices of a spec, in order.
std::vector<StageChoice*> choices(PipelineSpec& spec) {
  std::vector<StageChoice*> all = {&spec.broad_phase};
  for (StageChoice& choice : spec.element_culling) all.push_back(&choice);
  all.push_back(&spec.feature_culling);
  for (StageChoice& choice : spec.feature_filters) all.push_back(&choice);
  all.push_back(&spec.narrow_phase);
  return all;
}

StageChoice named(PipelineSpec& spec, const std::string& name) {
  for (const StageChoice* choice : choices(spec))
    if (choice->name == name) return *choice;
  return {name, {}};
}

void set_option(PipelineSpec& spec, const std::string& stage, const std::string& option, const std::string& value) {
  bool found = false;
  std::string known;
  for (StageChoice* choice : choices(spec)) {
    known += (known.empty() ? "" : ", ") + choice->name;
    if (choice->name != stage) continue;
    choice->options[option] = value;
    found = true;
  }
  if (!found) throw ConfigError(fmt::format("pipeline {} has no stage '{}'; it has {}", spec.name, stage, known));
}

void set_role(PipelineSpec& spec, const std::string& role, const std::string& value) {
  std::vector<StageChoice> stages;
  for (const std::string& name : names_in(value)) stages.push_back(named(spec, name));
  const auto one = [&](StageChoice& choice) {
    if (stages.size() != 1) throw ConfigError(fmt::format("{}: needs exactly one stage, not '{}'", role, value));
    choice = stages.front();
  };
  if (role == "broad-phase") one(spec.broad_phase);
  else if (role == "element-culling") spec.element_culling = stages;
  else if (role == "feature-culling") one(spec.feature_culling);
  else if (role == "feature-filters") spec.feature_filters = stages;
  else if (role == "narrow-phase") one(spec.narrow_phase);
  else
    throw ConfigError(fmt::format("no role '{}'; there are broad-phase, element-culling, feature-culling, "
                                  "feature-filters, narrow-phase, or stage.option=value",
                                  role));
}

}  // namespace

Registry Registry::standard() {
  Registry registry;
  registry.add(describe_kdop_bvh());
  registry.add(describe_spatial_hash());
  registry.add(describe_brute_force());
  registry.add(describe_csat());
  registry.add(describe_all_pairs());
  registry.add(describe_static_assignment());
  registry.add(describe_dynamic_assignment());
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
  std::apply(
      [&](const auto&... lists) {
        (std::for_each(lists.begin(), lists.end(),
                       [&](const auto& descriptor) {
                         if (descriptor.name == name)
                           throw ConfigError(fmt::format("a stage '{}' is registered already", name));
                       }),
         ...);
      },
      stages_);
}

void Registry::unknown(const char* what, const std::string& name, const std::string& known) {
  throw ConfigError(fmt::format("no {} '{}'; there are {}", what, name, known));
}

void Registry::add_pipeline(PipelineSpec spec) {
  for (const PipelineSpec& other : pipelines_)
    if (other.name == spec.name) throw ConfigError(fmt::format("a pipeline '{}' is registered already", spec.name));
  pipelines_.push_back(std::move(spec));
}

const PipelineSpec& Registry::pipeline(const std::string& name) const {
  std::string known;
  for (const PipelineSpec& spec : pipelines_) {
    if (spec.name == name) return spec;
    known += (known.empty() ? "" : ", ") + spec.name;
  }
  unknown("pipeline", name, known);
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
