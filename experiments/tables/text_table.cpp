#include <volccd/experiments/tables/text_table.hpp>

#include <algorithm>

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
