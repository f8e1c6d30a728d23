#include <volccd/experiments/tables/operation_table.hpp>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/experiments/tables/query_source.hpp>
#include <volccd/paper2011/bound_operations.hpp>
#include <volccd/paper2011/operations.hpp>

namespace volccd {

using nlohmann::json;

namespace {

std::string scene_name(const PlanContext& context) { return context.full ? "octopi" : "octopi-quick"; }

std::string mean_text(const json& row, const char* name) { return fmt::format("{:.1f}", row.at(name).get<double>()); }

/// The number that the paper prints, or "-".
std::string printed_text(const json& row, const char* name) {
  const json& paper = row.at("paper");
  return paper.is_object() && paper.contains(name) && paper.at(name).is_number() ? paper.at(name).dump() : "-";
}

bool is_coplanarity(const json& row) { return row.at("operation").get<std::string>().starts_with("coplanarity"); }

bool is_of_bounds(const json& row) { return row.at("kind") == "element" || row.at("kind") == "element-pair"; }

TitledTable test_table(const json& record) {
  TextTable table(
      {"operation", "kind", "tests", "+ -", "*", "/", "paper, + -", "paper, *", "paper, /", "compare", "sqrt", "ns"});
  for (const json& row : record.at("rows")) {
    if (is_of_bounds(row) || is_coplanarity(row)) continue;
    table.add({row.at("operation"), row.at("kind"), grouped(row.at("tests").get<std::uint64_t>()),
               mean_text(row, "additions"), mean_text(row, "multiplications"), mean_text(row, "divisions"),
               printed_text(row, "additions"), printed_text(row, "multiplications"), printed_text(row, "divisions"),
               mean_text(row, "comparisons"), mean_text(row, "square_roots"), mean_text(row, "ns")});
  }
  return {"Section 7.1: floating-point operations of a test, means", table,
          "of the reference implementation of 2011, on tests whose features have overlapping boxes; one thread\n"};
}

/// Nanoseconds of an operation on tests of a kind; 0 if there is no such row.
double ns_of(const json& record, const json& kind, const std::string& operation) {
  for (const json& row : record.at("rows"))
    if (row.at("kind") == kind && row.at("operation") == operation) return row.at("ns");
  return 0;
}

/// Nothing in a record without coplanarity.
std::optional<TitledTable> coplanarity_operation_table(const json& record) {
  TextTable table({"operation", "kind", "tests", "+ -", "*", "compare", "ns", "/ CSAT", "/ CSAT, axis given", "paper",
                   "found apart"},
                  2);
  bool any = false;
  for (const std::string features : {"", "-element"})
    for (const json& row : record.at("rows")) {
      const std::string operation = row.at("operation"), csat = "csat" + features;
      const double axis_given = ns_of(record, row.at("kind"), csat);
      const double with_axis = ns_of(record, row.at("kind"), csat + "-with-axis");
      if (operation != "coplanarity" + features && operation != csat && operation != csat + "-with-axis") continue;
      any = any || is_coplanarity(row);
      const auto over = [&](double ns) {
        return is_coplanarity(row) && ns > 0 ? ratio_text(row.at("ns").get<double>() / ns) : "-";
      };
      const std::string paper = printed_text(row, "over_csat");
      table.add({operation, row.at("kind"), grouped(row.at("tests").get<std::uint64_t>()), mean_text(row, "additions"),
                 mean_text(row, "multiplications"), mean_text(row, "comparisons"), mean_text(row, "ns"),
                 over(with_axis), over(axis_given), paper == "-" ? paper : paper + "x",
                 percent_text(row.at("positive").get<double>())});
    }
  if (!any) return std::nullopt;
  return TitledTable{"Section 7.2: coplanarity-based culling against CSAT, means", table,
                     "scalar code on the same tests; element: a vertex and all triangles of an element, or an edge and "
                     "all of its edges, apart if all are; / CSAT: time over that of CSAT, with the computation of its "
                     "axis and with the axis given, as the paper counts operations; one thread\n"};
}

/// The time of the same operation with k-DOPs; 0 if there is no such row.
double kdop_ns(const json& record, const json& row) {
  for (const json& other : record.at("rows"))
    if (other.at("kind") == row.at("kind") && other.at("operation").get<std::string>().starts_with("kdop"))
      return other.at("ns");
  return 0;
}

std::string printed_slower(const json& row) {
  const json& paper = row.at("paper");
  if (!paper.is_object() || !paper.contains("slower")) return "-";
  return fmt::format("{} to {}x", paper.at("slower").at(0).dump(), paper.at("slower").at(1).dump());
}

/// Rows: operations; nothing in a record without bounds.
std::optional<TitledTable> bound_table(const json& record) {
  TextTable table({"operation", "on", "samples", "+ -", "*", "/", "compare", "abs", "sqrt", "paper, + -", "paper, *",
                   "paper, compare", "paper, abs", "ns", "/ k-DOP", "paper, / k-DOP", "found apart"});
  bool any = false;
  for (const json& row : record.at("rows")) {
    if (!is_of_bounds(row)) continue;
    any = true;
    const double kdop = kdop_ns(record, row);
    table.add({row.at("operation"), row.at("kind") == "element" ? "an element" : "a pair",
               grouped(row.at("tests").get<std::uint64_t>()), mean_text(row, "additions"),
               mean_text(row, "multiplications"), mean_text(row, "divisions"), mean_text(row, "comparisons"),
               mean_text(row, "absolute_values"), mean_text(row, "square_roots"), printed_text(row, "additions"),
               printed_text(row, "multiplications"), printed_text(row, "comparisons"),
               printed_text(row, "absolute_values"), mean_text(row, "ns"),
               kdop > 0 ? ratio_text(row.at("ns").get<double>() / kdop) : "-", printed_slower(row),
               row.at("positive").is_null() ? "-" : percent_text(row.at("positive").get<double>())});
  }
  if (!any) return std::nullopt;
  return TitledTable{"Section 7.2: continuous OBBs against k-DOPs (k = 16), means", table,
                     "update: bounds of an element over the step; test: of pairs without a common vertex whose swept "
                     "boxes overlap; the paper's operations are those of a whole test; scalar code in doubles, both "
                     "conservative; no tree; one thread\n"};
}

}  // namespace

ExperimentPlan operation_plan(const PlanContext& context) {
  ExperimentPlan plan{"operations", context.full ? "full" : "quick", 1, {}};
  if (const auto file = context.file_of(scene_name(context))) plan.runs.push_back({"octopi", *file});
  return plan;
}

void operation_rows(const PlanContext& context, RecordFile& record) {
  if (record.has("rows")) return;
  const std::optional<std::string> file = context.file_of(scene_name(context));
  if (!file) throw ConfigError("operations: the scene " + scene_name(context) + " is not there");
  QuerySourceConfig source;
  source.candidates = true;
  source.sample = 2048;
  source.step = step_count(*file) / 2;
  std::vector<json> rows;
  const std::vector<KnownQueries> queries = load_queries(*file, source);
  std::vector<TestList> lists;
  for (const KnownQueries& known : queries) lists.push_back({known.kind, known.step, known.pairs});
  json counts = operation_counts(lists).at("rows");
  if (counts.empty()) throw ConfigError("operations: " + *file + " has no tests at its middle step");
  for (json& row : bound_operation_counts(queries.front().step)) counts.push_back(std::move(row));
  for (json& row : counts) {
    row["scene"] = "octopi";
    row["step"] = source.step;
    rows.push_back(std::move(row));
  }
  record.add("rows", rows);
}

std::vector<TitledTable> operation_tables(const json& record) {
  std::vector<TitledTable> tables = {test_table(record)};
  for (auto* more : {coplanarity_operation_table, bound_table})
    if (std::optional<TitledTable> table = more(record)) tables.push_back(std::move(*table));
  return tables;
}

}  // namespace volccd
