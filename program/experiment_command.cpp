#include <filesystem>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <volccd/core/median.hpp>
#include <volccd/experiments/records/record_file.hpp>
#include <volccd/experiments/tables/catalog.hpp>
#include <volccd/experiments/tables/compare_records.hpp>
#include <volccd/experiments/tables/scene_table.hpp>
#include <volccd/io/output_file.hpp>
#include <volccd/io/stats_json.hpp>
#include <volccd/program/command_line.hpp>
#include <volccd/program/commands.hpp>
#include <volccd/program/experiment_names.hpp>
#include <volccd/program/report.hpp>

namespace volccd {

namespace {

struct TableOptions {
  std::string name, results = kDefaultResults, format = "text", output = "-";
  ReportOptions report;
};

nlohmann::json tables_json(const std::string& name, const std::vector<TitledTable>& tables) {
  nlohmann::json list = nlohmann::json::array();
  for (const TitledTable& table : tables) {
    nlohmann::json entry = to_json(table.table);
    entry["title"] = table.title;
    entry["note"] = table.note;
    list.push_back(std::move(entry));
  }
  return {{"experiment", name}, {"tables", list}};
}

/// This table exists as text only.
int print_scene_table(const TableOptions& options) {
  if (options.format != "text") throw ConfigError(fmt::format("--format: the table of {} is text only", options.name));
  const std::string file = (std::filesystem::path(options.results) / (options.name + ".json")).string();
  const nlohmann::json records = read_json_file(file);
  if (!records.is_array()) throw InputError(file, "", "is not the record of a complete run");
  const Report report(options.report);
  const bool to_screen = is_standard_output(options.output);
  const std::string text =
      untitled_text(scene_table(records.get<std::vector<nlohmann::json>>()), to_screen ? report.width() : kTextWidth);
  report.write("experiment table", {{"experiment", options.name}, {"tables", nlohmann::json::array()}, {"text", text}});
  if (!to_screen || !(options.report.json || options.report.quiet)) write_text_file(options.output, text);
  return kDone;
}

int print_table(const TableOptions& options) {
  if (options.name == kScenesExperiment) return print_scene_table(options);
  const ExperimentKind* kind = find_kind(options.name);
  if (!kind) unknown_experiment("tables of", options.name);
  const std::string file = (std::filesystem::path(options.results) / (options.name + ".json")).string();
  const std::map<std::string, TableFormat> formats = {{"text", TableFormat::text},
                                                      {"markdown", TableFormat::markdown},
                                                      {"csv", TableFormat::csv},
                                                      {"latex", TableFormat::latex}};
  const std::vector<TitledTable> tables = kind->tables(read_record(file));
  const Report report(options.report);
  report.write("experiment table", tables_json(options.name, tables));
  const bool to_screen = is_standard_output(options.output);
  if (!to_screen || !(options.report.json || options.report.quiet))
    write_text_file(options.output,
                    render(tables, formats.at(options.format), to_screen ? report.width() : kTextWidth));
  return kDone;
}

struct CompareOptions {
  std::string a, b;
  ReportOptions report;
};

int compare(const CompareOptions& options) {
  const Report report(options.report);
  const RecordComparison result = compare_records(options.a, options.b);
  std::vector<double> drifts;
  for (const RecordComparison::Drift& drift : result.drifts) drifts.push_back(drift.ratio);
  report.write("experiment compare", {{"compared", result.compared},
                                      {"slower", result.slower},
                                      {"faster", result.faster},
                                      {"other_counts", result.other_counts},
                                      {"drifts", drifts},
                                      {"single", result.single},
                                      {"only_on_one_side", result.only_on_one_side},
                                      {"without_times", result.without_times},
                                      {"differences", to_json(result.table)}});
  if (result.slower + result.faster + result.other_counts > 0) report.print("{}\n", result.table.text(report.width()));
  report.print("{} compared: {} slower, {} faster beyond the tolerance, {} with other counts\n", result.compared,
               result.slower, result.faster, result.other_counts);
  if (!drifts.empty())
    report.print(
        "all pipelines of a scene together: {:.2f} to {:.2f} times the time, {:.2f} on the median scene\n"
        "(`scripts/benchmark-guard` tells whether the latter is the machine or what all of them share)\n",
        drifts.front(), drifts.back(), median(drifts));
  if (result.single > 0)
    report.print("{} with a single round: their tolerance is {:.0f} %\n", result.single, 100 * kMaxTimeTolerance);
  if (!result.without_times.empty())
    report.print("no runs of pipelines, not compared: {}\n", fmt::join(result.without_times, ", "));
  for (const std::string& what : result.only_on_one_side) report.print("not compared: {}\n", what);
  return result.slower + result.other_counts + result.only_on_one_side.size() > 0 ? kDifferent : kDone;
}

void add_table_command(CLI::App& command, Action& action) {
  const auto options = std::make_shared<TableOptions>();
  CLI::App* table = command.add_subcommand("table", "prints the tables of a record, without running anything");
  table->add_option("NAME", options->name, "the experiment")->required();
  table->add_option("--results", options->results, "folder with its record")->capture_default_str();
  table->add_option("--format", options->format, "text, markdown, csv or latex (booktabs)")
      ->check(one_of({"text", "markdown", "csv", "latex"}))
      ->capture_default_str();
  table->add_option("-o,--output", options->output, "file; - is the standard output")->capture_default_str();
  options->report.add_to(*table);
  table->footer("Example:\n  volccd experiment table table1 --results results/ --format latex -o table1.tex");
  table->callback([options, &action] { action = [options] { return print_table(*options); }; });
}

void add_compare_command(CLI::App& command, Action& action) {
  const auto options = std::make_shared<CompareOptions>();
  CLI::App* compare_command = command.add_subcommand(
      "compare", "compares two folders of records: times beyond the spread of the rounds, and counts");
  compare_command->add_option("A", options->a, "folder of the earlier records")->required();
  compare_command->add_option("B", options->b, "folder of the later records")->required();
  compare_command->footer(
      "Exit code 1 if anything is slower by more than its tolerance, if counts differ, or if one folder alone has a "
      "record, an entrant or a step. A time is compared with the median of all pipelines on the same scene "
      "(\"of all\"), because machines change their speed. The tolerance is the spread of the rounds, at least 3 % and "
      "at most 25 %; with a single round it is 25 %. What all pipelines of a scene changed by is compared with the "
      "median scene, with 25 %.\n"
      "Example:\n  volccd experiment compare results/ build/results/");
  options->report.add_to(*compare_command);
  compare_command->callback([options, &action] { action = [options] { return compare(*options); }; });
}

int list_experiments(const ReportOptions& options) {
  const Report report(options);
  nlohmann::json list = nlohmann::json::array();
  const auto add = [&](const char* name, const char* description) {
    report.print("{}", labelled(name, description, 13));
    list.push_back({{"name", name}, {"description", description}});
  };
  for (const ExperimentKind& kind : experiment_kinds()) add(kind.name, kind.description);
  add(kScenesExperiment, kScenesDescription);
  add("all", "all of these");
  report.write("experiment list", {{"experiments", list}});
  return kDone;
}

void add_list_command(CLI::App& command, Action& action) {
  CLI::App* list = command.add_subcommand("list", "what there is");
  const auto options = std::make_shared<ReportOptions>();
  options->add_to(*list);
  list->callback([options, &action] { action = [options] { return list_experiments(*options); }; });
}

}  // namespace

void add_experiment_command(CLI::App& app, const Registry& registry, Action& action) {
  CLI::App* command = app.add_subcommand("experiment", "runs measurements and makes their tables");
  command->require_subcommand(1);
  add_list_command(*command, action);
  add_experiment_run_command(*command, registry, action);
  add_table_command(*command, action);
  add_compare_command(*command, action);
}

}  // namespace volccd
