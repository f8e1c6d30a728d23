#include <volccd/experiments/tables/text_table.hpp>

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

namespace volccd {

std::string TextTable::text() const {
  std::vector<std::size_t> widths;
  for (const auto& row : rows_) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  }
  std::size_t line = 0;
  for (const std::size_t width : widths) line += width + 2;
  const std::string rule = std::string(line > 2 ? line - 2 : 0, '-') + "\n";
  std::string text;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    if (r == 1 || std::find(rules_.begin(), rules_.end(), r) != rules_.end()) text += rule;
    std::string row;
    for (std::size_t c = 0; c < rows_[r].size(); ++c)
      row += c == 0 ? fmt::format("{:<{}}", rows_[r][c], widths[c]) : fmt::format("  {:>{}}", rows_[r][c], widths[c]);
    text += row.substr(0, row.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

namespace {

/// Each row as one line: `cell` of each cell, with `between` and within `before` and `after`.
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

std::string render(const std::vector<TitledTable>& tables, TableFormat format) {
  std::string text;
  for (const TitledTable& table : tables) {
    if (!text.empty()) text += "\n";
    switch (format) {
      case TableFormat::text: text += table.title + "\n\n" + table.table.text() + table.note; break;
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
