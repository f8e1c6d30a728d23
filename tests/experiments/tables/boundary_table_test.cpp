// The table that compares all features with those of the boundary, from rows with known numbers.
#include <volccd/experiments/tables/boundary_table.hpp>

#include <gtest/gtest.h>

#include "support/table_cells.hpp"

namespace volccd::test {
namespace {

using nlohmann::json;

json row(const char* scene, unsigned threads, const char* pipeline, const char* mesh, int motion, double seconds) {
  return {{"scene", scene},     {"threads", threads}, {"pipeline", pipeline},
          {"mesh", mesh},       {"step", motion},     {"round", 0},
          {"seconds", seconds}, {"elements", 100},    {"topology_seconds", 0.001},
          {"contacts", 3}};
}

TEST(BoundaryTable, DividesTimesOfTheSameThreads) {
  const json record = {
      {"rows",
       {row("bullet", 1, "VolCCD", "whole", 0, 0.011), row("bullet", 1, "VolCCD", "whole", 1, 0.015),
        row("bullet", 1, "VolCCD", "boundary", 0, 0.005), row("bullet", 1, "VolCCD", "boundary", 1, 0.007),
        row("bullet", 2, "VolCCD", "whole", 0, 0.008), row("bullet", 2, "VolCCD", "boundary", 0, 0.005),
        row("octopi", 1, "VolCCD", "whole", 0, 0.003), row("octopi", 1, "VolCCD", "boundary", 0, 0.007),
        row("bullet-surface", 1, "VolCCD", "boundary", 0, 0.027)}}};
  const std::vector<TitledTable> tables = boundary_tables(record);
  ASSERT_EQ(tables.size(), 2u);
  ASSERT_EQ(tables[0].table.rows().size(), 4u) << "scenes that have both, by threads";
  EXPECT_EQ(cell(tables[0], 1, "all, ms"), "14") << "edits included, mean of 12 and 16";
  EXPECT_EQ(cell(tables[0], 1, "all / boundary"), "2x");
  EXPECT_EQ(cell(tables[0], 1, "contacts, all"), "6");
  EXPECT_EQ(cell(tables[0], 2, "all / boundary"), "1.5x");
  EXPECT_EQ(cell(tables[0], 3, "all / boundary"), "0.5x");
  ASSERT_EQ(tables[1].table.rows().size(), 2u);
  EXPECT_EQ(cell(tables[1], 1, "ratio"), "0.5x") << "14 ms over 28 ms";
  json one = {{"rows", json::array()}};
  for (const json& of : record.at("rows"))
    if (of.at("scene") == "octopi") one["rows"].push_back(of);
  EXPECT_EQ(boundary_tables(one).size(), 1u);
}

/// The paper: 3.2 on one thread, 1.3 with SIMD and several threads.
TEST(BoundaryTable, ThePapersRatiosStandBesideWhatTheyAreOf) {
  json record = {{"rows", json::array()}};
  for (const unsigned threads : {1u, 2u})
    for (const char* pipeline : {"VolCCD-2011", "VolCCD", "VolCCD+"})
      for (const char* scene : {"octopi", "bullet", "bullet-boundary"})
        for (const char* mesh : {"whole", "boundary"})
          record["rows"].push_back(row(scene, threads, pipeline, mesh, 0, 0.01));
  std::size_t beside = 0;
  for (const TitledTable& table : boundary_tables(record))
    for (std::size_t line = 1; line < table.table.rows().size(); ++line) {
      const bool of_bullet =
          cell(table, line, "scene") == "bullet" || cell(table, line, "boundary of") != "no column boundary of";
      const bool scalar = cell(table, line, "pipeline") == "VolCCD-2011", serial = cell(table, line, "threads") == "1";
      const char* expected = !of_bullet ? "-" : scalar && serial ? "3.2x" : !scalar && !serial ? "1.3x" : "-";
      EXPECT_EQ(cell(table, line, "paper"), expected) << table.title << ", line " << line;
      beside += cell(table, line, "paper") != "-";
    }
  EXPECT_EQ(beside, 2u * 3u) << "in both tables: VolCCD-2011 on one thread, VolCCD and VolCCD+ on two";
}

}  // namespace
}  // namespace volccd::test
