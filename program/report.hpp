// The output of a command: text tables, or one JSON document with --json; no text with --quiet.
#pragma once

#include <cstdio>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json_fwd.hpp>

#include <volccd/core/options.hpp>
#include <volccd/experiments/tables/text_table.hpp>

namespace volccd {

/// --json and --quiet. It must outlive the parsing.
struct ReportOptions {
  bool json = false, quiet = false;

  void add_to(CLI::App& command);
  void add_quiet_to(CLI::App& command);  ///< for commands without a table
};

class Report {
 public:
  /// `people`: the stream for text, unless text is disabled.
  explicit Report(const ReportOptions& options, std::FILE* people = stdout)
      : options_(options), people_(options.json || options.quiet ? nullptr : people) {}

  /// Prints text, unless --json or --quiet is given.
  template <class... T>
  void print(fmt::format_string<T...> format, T&&... arguments) const {
    if (people_) fmt::print(people_, format, std::forward<T>(arguments)...);
  }
  /// The columns that tables may take: those of the terminal that print() writes to, else kTextWidth.
  std::size_t width() const;
  bool for_people() const { return people_ != nullptr; }
  bool is_json() const { return options_.json; }
  /// The stream of print(); null if there is none.
  std::FILE* people() const { return people_; }

  /// With --json: prints `document`, an object, with "command" added, to the standard output. Bytes that are not UTF-8
  /// are replaced. docs/output.schema.json describes the documents.
  void write(const char* command, nlohmann::json document) const;

 private:
  const ReportOptions& options_;
  std::FILE* people_;
};

/// [{"name", "default", "allowed", "description"}].
nlohmann::json options_json(const std::vector<OptionInfo>& options);

/// {"columns": [...], "rows": [[...], ...]}, cells as text; numbers without separators of groups.
nlohmann::json to_json(const TextTable& table);

}  // namespace volccd
