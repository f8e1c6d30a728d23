// Aligned tables on a terminal.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace volccd {

/// Column 0 is flush left, the others flush right; widths follow the content.
class TextTable {
 public:
  explicit TextTable(std::vector<std::string> header) : rows_{std::move(header)} {}

  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  /// A rule before the next row.
  void rule() { rules_.push_back(rows_.size()); }
  /// The header, then the rows as they were added; rows may be shorter or longer than the header.
  const std::vector<std::vector<std::string>>& rows() const { return rows_; }
  /// With a line break at the end; a rule under the header.
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

/// A table of an experiment, with what to know to read it.
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
