#include <volccd/program/report.hpp>

#include <sys/ioctl.h>

#include <algorithm>

#include <nlohmann/json.hpp>

#include <volccd/program/progress.hpp>

namespace volccd {

void ReportOptions::add_to(CLI::App& command) {
  command.add_flag("--json", json, "print one JSON document in place of tables (docs/json_output.md)");
  add_quiet_to(command);
}

void ReportOptions::add_quiet_to(CLI::App& command) {
  command.add_flag_callback(
      "--quiet",
      [this] {
        quiet = true;
        Progress::silence();
      },
      "print no tables and no progress, only errors, warnings, and outputs that are requested by name");
}

std::size_t Report::width() const {
  constexpr std::size_t min_width = 40;
  winsize size{};
  if (!people_ || ioctl(fileno(people_), TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return kTextWidth;
  return std::max<std::size_t>(size.ws_col, min_width);
}

void Report::write(const char* command, nlohmann::json document) const {
  if (!options_.json) return;
  document["command"] = command;
  fmt::print("{}\n", document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
}

nlohmann::json options_json(const std::vector<OptionInfo>& options) {
  nlohmann::json list = nlohmann::json::array();
  for (const OptionInfo& option : options)
    list.push_back({{"name", option.name},
                    {"default", option.default_value},
                    {"allowed", option.allowed},
                    {"description", option.description}});
  return list;
}

nlohmann::json to_json(const TextTable& table) {
  nlohmann::json rows = nlohmann::json::array();
  for (std::vector<std::string> row : table.rows()) {
    for (std::string& cell : row)
      if (!cell.empty() && cell.find_first_not_of("0123456789,") == std::string::npos)
        cell.erase(std::remove(cell.begin(), cell.end(), ','), cell.end());
    rows.push_back(std::move(row));
  }
  const nlohmann::json columns = rows.front();
  rows.erase(0);
  return {{"columns", columns}, {"rows", rows}};
}

}  // namespace volccd
