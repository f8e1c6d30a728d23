// Cells of a table, by the header of their column.
#pragma once

#include <string>

#include <volccd/experiments/tables/text_table.hpp>

namespace volccd::test {

/// The cell of a line (from 1) in the first column with this header; if there is none, a text that says so.
inline std::string cell(const TitledTable& table, std::size_t line, const std::string& column) {
  const auto& rows = table.table.rows();
  for (std::size_t c = 0; c < rows[0].size(); ++c)
    if (rows[0][c] == column) return rows.at(line).at(c);
  return "no column " + column;
}

}  // namespace volccd::test
