#include <volccd/experiments/tables/coplanarity_table.hpp>

#include <fmt/format.h>

namespace volccd {

using nlohmann::json;

namespace {

constexpr const char* kElementsByCsat = "elements: CSAT, ";

/// What is culled with on features, and its stages.
struct FeatureCulling {
  const char *name, *stages;
};
constexpr FeatureCulling kNoFilter = {"none", "none"}, kCsatFilter = {"CSAT", "feature-csat"},
                         kCoplanarityFilter = {"coplanarity", "coplanarity"},
                         kBothFilters = {"coplanarity + CSAT", "coplanarity,feature-csat"};

/// Nanoseconds of the stages of a role, for each of `tests`; 0 if it has no stage.
double ns_of_role(const Rows& rows, const std::string& role, double tests) {
  return tests > 0 ? 1e9 * (rows.sum(role + "_prepare_s") + rows.sum(role + "_run_s")) / tests : 0;
}

/// One combination in one scene.
struct CullingLine {
  CullingLine(const Rows& all, const std::string& variant) : rows(all.with("variant", variant)) {
    if (rows.empty()) return;
    const double owned = rows.sum("owned_tests");
    feature_ns = ns_of_role(rows, "feature_filter", owned + rows.sum("orphan_tests"));
    const Rows plain = all.with("variant", kNoFilter.name);
    if (!plain.empty()) element_ns = ns_of_role(rows, "element_culling", plain.sum("owned_tests"));
  }

  Rows rows;
  double feature_ns = 0, element_ns = 0;  ///< of a test that filters get; of one that pairs have without culling
};

std::string ns_text(double ns) { return ns > 0 ? number_text(ns) : "-"; }
std::string over(double a, double b) { return a > 0 && b > 0 ? ratio_text(a / b) : "-"; }

}  // namespace

void add_coplanarity(const Registry& registry, std::vector<Entrant>& entrants) {
  for (const bool elements : {false, true})
    for (const FeatureCulling& features : {kNoFilter, kCsatFilter, kCoplanarityFilter, kBothFilters}) {
      std::vector<std::string> settings = {"narrow-phase=cubic", "cubic.axis_test=false", "cubic.coplanarity=false",
                                           std::string("feature-filter=") + features.stages};
      if (std::string(features.stages).find("feature-csat") != std::string::npos)
        settings.push_back("feature-csat.axes=first");
      if (!elements) settings.push_back("element-culling=none");
      entrants.push_back(entrant(registry, kCoplanarityTable, "VolCCD", settings));
      entrants.back().variant = (elements ? kElementsByCsat : "") + std::string(features.name);
    }
}

TitledTable coplanarity_table(const Rows& rows, const std::string& title) {
  TextTable table({"culling", "ms a step", "ns/test, elements", "features", "/ CSAT, features", "paper, features",
                   "/ CSAT, elements", "paper, elements", "tests left", "left", "contacts"});
  const CullingLine plain(rows, kNoFilter.name), element_csat(rows, kElementsByCsat + std::string(kNoFilter.name));
  for (const json& variant : rows.values("variant")) {
    const std::string name = variant;
    const bool elements = name.starts_with(kElementsByCsat), coplanarity = name.ends_with(kCoplanarityFilter.name);
    const CullingLine line(rows, name), csat(rows, (elements ? kElementsByCsat : "") + std::string(kCsatFilter.name));
    const bool against_elements = coplanarity && !elements;
    const double all = plain.rows.empty() ? 0 : plain.rows.tests();
    table.add({name, number_text(line.rows.mean_ms(kStepTime)), ns_text(elements ? line.element_ns : 0),
               ns_text(line.feature_ns), coplanarity ? over(line.feature_ns, csat.feature_ns) : "-",
               coplanarity ? "2x" : "-", against_elements ? over(line.feature_ns, element_csat.element_ns) : "-",
               against_elements ? "6x" : "-", grouped(static_cast<std::uint64_t>(line.rows.tests())),
               all > 0 ? percent_text(line.rows.tests() / all) : "-",
               grouped(static_cast<std::uint64_t>(line.rows.sum("contacts")))});
  }
  return {title, table,
          "VolCCD with this culling; ms: mean over steps of medians over rounds; ns/test: time of the culling stages "
          "over the tests that it is applied to, for elements those that the pairs have without culling, for features "
          "those that get to the filter; / CSAT: coplanarity on features over CSAT on features, and over CSAT on "
          "elements; left: in per cent of the tests without culling; the paper's: single tests of a vertex and a "
          "triangle (2x), a vertex and a tetrahedron (6x); elementary test: cubic without its own filters\n"};
}

}  // namespace volccd
