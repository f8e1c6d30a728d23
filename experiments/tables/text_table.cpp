#include <volccd/experiments/tables/text_table.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace volccd {

namespace {

constexpr std::size_t kGap = 2;  ///< blanks between columns

std::size_t longest_word(const std::string& text) {
  std::size_t longest = 0, begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    longest = std::max(longest, end - begin);
    begin = end + 1;
  }
  return longest;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

std::size_t width_of(const std::vector<std::size_t>& widths) {
  std::size_t width = 0;
  for (const std::size_t one : widths) width += one + kGap;
  return width - std::min(width, kGap);
}

/// Widths of the columns. Columns whose headers have blanks are made narrower until a row fits, or no column can be
/// made narrower.
std::vector<std::size_t> column_widths(const std::vector<std::vector<std::string>>& rows, std::size_t width) {
  std::vector<std::size_t> widths, min;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    widths.resize(std::max(widths.size(), rows[r].size()));
    min.resize(widths.size());
    for (std::size_t c = 0; c < rows[r].size(); ++c) {
      widths[c] = std::max(widths[c], rows[r][c].size());
      min[c] = std::max(min[c], r == 0 ? longest_word(rows[r][c]) : rows[r][c].size());
    }
  }
  while (width_of(widths) > width) {
    std::size_t widest = 0;
    for (std::size_t c = 1; c < widths.size(); ++c)
      if (widths[c] - min[c] > widths[widest] - min[widest]) widest = c;
    if (widths.empty() || widths[widest] == min[widest]) break;
    --widths[widest];
  }
  return widths;
}

}  // namespace

TextTable::TextTable(std::vector<std::string> header, std::size_t labels) : rows_{std::move(header)}, labels_(labels) {
  [[maybe_unused]] std::vector<std::string> names = rows_[0];
  std::sort(names.begin(), names.end());
  assert(std::adjacent_find(names.begin(), names.end()) == names.end());
}

std::string TextTable::text(std::size_t width) const {
  const std::vector<std::size_t> widths = column_widths(rows_, width);
  std::string text;
  for (std::size_t c = 0; c < widths.size();) {
    std::vector<std::size_t> columns;
    std::size_t line = 0;
    for (std::size_t label = 0; label < labels_ && c >= labels_; ++label) {
      line += widths[label] + (label > 0 ? kGap : 0);
      columns.push_back(label);
    }
    // At least one more column is taken, so that the loop ends.
    do {
      line += widths[c] + (columns.empty() ? 0 : kGap);
      columns.push_back(c++);
    } while (c < widths.size() && line + kGap + widths[c] <= width);
    text += (text.empty() ? "" : "\n") + block(columns, widths);
  }
  return text;
}

std::string TextTable::block(const std::vector<std::size_t>& columns, const std::vector<std::size_t>& widths) const {
  std::size_t line = 0;
  for (const std::size_t c : columns) line += widths[c] + kGap;
  const std::string rule = std::string(line - kGap, '-') + "\n";
  std::string text;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    if (r == 1 || std::find(rules_.begin(), rules_.end(), r) != rules_.end()) text += rule;
    std::vector<std::vector<std::string>> cells;  // lines of each cell
    std::size_t height = 1;
    for (const std::size_t c : columns) {
      const std::string& cell = c < rows_[r].size() ? rows_[r][c] : std::string();
      cells.push_back(r == 0 ? lines_of(wrapped(cell, widths[c])) : std::vector<std::string>{cell});
      height = std::max(height, cells.back().size());
    }
    for (std::size_t i = 0; i < height; ++i) {
      std::string row;
      for (std::size_t k = 0; k < columns.size(); ++k) {
        // Cells of the header are aligned at the bottom.
        const std::size_t above = height - cells[k].size();
        const std::string cell = i < above ? std::string() : cells[k][i - above];
        const std::size_t width = widths[columns[k]];
        row += k == 0 && columns[k] == 0 ? fmt::format("{:<{}}", cell, width)
                                         : fmt::format("{}{:>{}}", k == 0 ? "" : "  ", cell, width);
      }
      text += row.substr(0, row.find_last_not_of(' ') + 1) + "\n";
    }
  }
  return text;
}

std::string wrapped(const std::string& text, std::size_t width) {
  std::string result;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string line = text.substr(begin, end - begin);
    const std::string indentation(std::min(line.find_first_not_of(' '), line.size()), ' ');
    while (line.size() > width) {
      std::size_t blank = line.rfind(' ', width);
      if (blank == std::string::npos || blank < indentation.size()) blank = line.find(' ', indentation.size());
      if (blank == std::string::npos) break;
      result += line.substr(0, line.find_last_not_of(' ', blank) + 1) + "\n";
      line = indentation + line.substr(std::min(line.find_first_not_of(' ', blank), line.size()));
    }
    result += line;
    if (end < text.size()) result += "\n";
    begin = end + 1;
  }
  return result;
}

std::string labelled(const std::string& label, const std::string& text, std::size_t indentation) {
  // A label that is too long gets a line of its own.
  const bool fits = label.size() < indentation;
  std::string result =
      fits ? label + std::string(indentation - label.size(), ' ') : label + "\n" + std::string(indentation, ' ');
  const std::string lines = wrapped(text, kTextWidth - indentation);
  for (const char c : lines) {
    result += c;
    if (c == '\n') result += std::string(indentation, ' ');
  }
  return result + "\n";
}

namespace {

/// Writes each row as one line: `cell` of each cell, with `between` between cells, `before` before and `after` after
/// them.
template <class Cell>
std::string line_of(const std::vector<std::string>& row, const char* before, const char* between, const char* after,
                    Cell&& cell) {
  std::string line = before;
  for (std::size_t c = 0; c < row.size(); ++c) line += (c ? between : "") + cell(row[c]);
  return line + after + "\n";
}

std::string escaped(const std::string& text, std::string_view special) {
  std::string result;
  for (const char c : text) {
    if (special.find(c) != std::string_view::npos) result += '\\';
    result += c;
  }
  return result;
}

std::string csv_cell(std::string text) {
  // Numbers are grouped for readers; programs want them plain.
  if (!text.empty() && text.find_first_not_of("0123456789,") == std::string::npos)
    text.erase(std::remove(text.begin(), text.end(), ','), text.end());
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted;
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return '"' + quoted + '"';
}

}  // namespace

std::string TextTable::markdown() const {
  std::string text;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    text += line_of(rows_[r], "| ", " | ", " |", [](const std::string& cell) { return escaped(cell, "|"); });
    if (r == 0) {
      text += "|---|";
      for (std::size_t c = 1; c < rows_[0].size(); ++c) text += "---:|";
      text += "\n";
    }
  }
  return text;
}

std::string TextTable::csv() const {
  std::string text;
  for (const auto& row : rows_) text += line_of(row, "", ",", "", csv_cell);
  return text;
}

std::string TextTable::latex() const {
  std::string text =
      "\\begin{tabular}{l" + std::string(rows_[0].empty() ? 0 : rows_[0].size() - 1, 'r') + "}\n\\toprule\n";
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    if (r == 1 || std::find(rules_.begin(), rules_.end(), r) != rules_.end()) text += "\\midrule\n";
    text += line_of(rows_[r], "", " & ", " \\\\", [](const std::string& cell) { return escaped(cell, "&%$#_{}"); });
  }
  return text + "\\bottomrule\n\\end{tabular}\n";
}

std::string untitled_text(const TitledTable& table, std::size_t width) {
  return table.table.text(width) + "\n" + wrapped(table.note, std::min(width, kTextWidth));
}

std::string render(const std::vector<TitledTable>& tables, TableFormat format, std::size_t width) {
  const std::size_t prose = std::min(width, kTextWidth);
  std::string text;
  for (const TitledTable& table : tables) {
    if (!text.empty()) text += "\n";
    switch (format) {
      case TableFormat::text:
        text += wrapped(table.title, prose) + "\n\n" + table.table.text(width) + wrapped(table.note, prose);
        break;
      case TableFormat::markdown:
        text += "### " + table.title + "\n\n" + table.table.markdown() + "\n" + table.note;
        break;
      case TableFormat::csv: text += "# " + table.title + "\n" + table.table.csv(); break;
      case TableFormat::latex: text += "% " + table.title + "\n" + table.table.latex(); break;
    }
  }
  return text;
}

std::string grouped(std::uint64_t n) {
  std::string text = std::to_string(n);
  for (std::size_t i = text.size(); i > 3; i -= 3) text.insert(i - 3, ",");
  return text;
}

std::string number_text(double value) {
  if (std::abs(value) < 999.5) return fmt::format("{:.3g}", value);
  if (!(std::abs(value) < 1e18)) return fmt::format("{:.3g}", value);  // also what is not finite
  return (value < 0 ? "-" : "") + grouped(static_cast<std::uint64_t>(std::llround(std::abs(value))));
}

std::string counted(std::uint64_t n, std::string_view what) {
  return fmt::format("{} {}{}", grouped(n), what, n == 1 ? "" : "s");
}

std::string fixed_text(double value, int digits) {
  const std::string text = fmt::format("{:.{}f}", value, digits);
  return text.starts_with('-') && text.find_first_of("123456789") == std::string::npos ? text.substr(1) : text;
}

std::string duration(double seconds) {
  const auto with = [](double value, const char* unit) {
    return fmt::format("{:.{}f} {}", value, value >= 100 ? 0 : value >= 10 ? 1 : 2, unit);
  };
  if (seconds >= 1) return with(seconds, "s");
  if (seconds >= 1e-3) return with(seconds * 1e3, "ms");
  return with(seconds * 1e6, "us");
}

std::string memory(std::size_t bytes) {
  const double value = static_cast<double>(bytes);
  if (value >= 1e9) return fmt::format("{:.2f} GB", value / 1e9);
  if (value >= 1e6) return fmt::format("{:.1f} MB", value / 1e6);
  return fmt::format("{:.1f} KB", value / 1e3);
}

}  // namespace volccd
