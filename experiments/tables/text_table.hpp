// Aligned tables on a terminal.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace volccd {

/// Column 0 is aligned left, the others right; the widths follow from the content.
class TextTable {
 public:
  explicit TextTable(std::vector<std::string> header) : rows_{std::move(header)} {}

  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  /// Adds a horizontal rule before the next row.
  void rule() { rules_.push_back(rows_.size()); }
  /// The table as plain text, with a rule under the header and a line break at the end.
  std::string text() const;
  std::string markdown() const;
  std::string csv() const;
  /// A tabular environment for booktabs.
  std::string latex() const;

 private:
  std::vector<std::vector<std::string>> rows_;
  std::vector<std::size_t> rules_;
};

enum class TableFormat { text, markdown, csv, latex };

/// A table of an experiment, with a title and a note.
struct TitledTable {
  std::string title;
  TextTable table;
  std::string note;
};

/// Titles, tables and notes, one after the other.
std::string render(const std::vector<TitledTable>& tables, TableFormat format);

/// 1234567 -> "1,234,567".
std::string grouped(std::uint64_t n);
/// Seconds as "1.23 s", "45.6 ms", "789 us", three significant digits.
std::string duration(double seconds);
/// Bytes as "12.3 MB".
std::string memory(std::size_t bytes);

}  // namespace volccd
