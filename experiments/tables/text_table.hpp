// Aligned tables on a terminal.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace volccd {

/// Greatest width of text in files and pipes, in columns; what a terminal has may be more or less.
inline constexpr std::size_t kTextWidth = 100;

/// Column 0 is aligned left, the others right; the widths follow from the content. Names of columns are distinct.
class TextTable {
 public:
  /// `labels`: columns at the beginning that say what a row is about, at least 1.
  explicit TextTable(std::vector<std::string> header, std::size_t labels = 1);

  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  /// Adds a horizontal rule before the next row.
  void rule() { rules_.push_back(rows_.size()); }
  /// The table as plain text, with a rule under the header and a line break at the end. If a row is wider than
  /// `width`, words of the header go to several lines; if that does not suffice, the remaining columns follow in a
  /// separate table, with the labels repeated. (A single cell that is wider is not changed.)
  std::string text(std::size_t width = kTextWidth) const;
  /// The header, then the rows.
  const std::vector<std::vector<std::string>>& rows() const { return rows_; }
  std::string markdown() const;
  std::string csv() const;
  /// A tabular environment for booktabs.
  std::string latex() const;

 private:
  std::string block(const std::vector<std::size_t>& columns, const std::vector<std::size_t>& widths) const;

  std::vector<std::vector<std::string>> rows_;
  std::size_t labels_;
  std::vector<std::size_t> rules_;
};

enum class TableFormat { text, markdown, csv, latex };

/// A table of an experiment, with a title and a note.
struct TitledTable {
  std::string title;
  TextTable table;
  std::string note;
};

/// `text` in lines of at most `width` characters, broken at blanks; line breaks that it has stay, and so does the
/// indentation of a line, on those that go on with it.
std::string wrapped(const std::string& text, std::size_t width = kTextWidth);

/// `text` behind `label`, in lines of kTextWidth of which the others are indented to column `indentation`, which the
/// label is filled up to. With a line break at the end.
std::string labelled(const std::string& label, const std::string& text, std::size_t indentation);

/// Titles, tables and notes, one after the other; as text, tables in lines of `width`, and the rest in lines of
/// kTextWidth at most.
std::string render(const std::vector<TitledTable>& tables, TableFormat format, std::size_t width = kTextWidth);
/// Table and note as text, without the title.
std::string untitled_text(const TitledTable& table, std::size_t width = kTextWidth);

/// 1234567 -> "1,234,567".
std::string grouped(std::uint64_t n);
/// Three significant digits, "0.0123" or "12.3", or all digits before the decimal point, "1,140". Numbers below 1e-4
/// have an exponent.
std::string number_text(double value);
/// "1 frame", "1,234 frames".
std::string counted(std::uint64_t n, std::string_view what);
/// With `digits` digits after the decimal point; never "-0".
std::string fixed_text(double value, int digits);
/// Seconds as "1.23 s", "45.6 ms", "789 us", three significant digits.
std::string duration(double seconds);
/// Bytes as "12.3 MB".
std::string memory(std::size_t bytes);

}  // namespace volccd
