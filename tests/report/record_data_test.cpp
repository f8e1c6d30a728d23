// The records of a folder as data of a report.
#include <volccd/report/record_data.hpp>

#include <fstream>
#include <set>

#include <gtest/gtest.h>

#include <volccd/core/error.hpp>

#include "support/scratch_folder.hpp"

namespace volccd {
namespace {

using nlohmann::json;

TEST(ReportRecords, TablesAndProvenanceOfTheKeptResults) {
  const auto [records, points] = data_of_records(VOLCCD_SOURCE_DIR "/results");
  std::set<std::string> names;
  for (const json& record : records) {
    names.insert(record.at("name").get<std::string>());
    ASSERT_FALSE(record.at("tables").empty()) << record.at("name");
    for (const json& table : record.at("tables")) {
      EXPECT_FALSE(table.at("header").empty());
      for (const json& row : table.at("rows")) EXPECT_LE(row.size(), table.at("header").size()) << table.at("title");
    }
    for (const char* key : {"commit", "cpu", "date"})
      EXPECT_TRUE(record.at("provenance").contains(key)) << record.at("name");
  }
  for (const char* name : {"table1", "culling", "plus", "scenes", "feature-sets"})
    EXPECT_EQ(1u, names.count(name)) << name;
  bool octopi = false;
  for (const RecordedInput& input : inputs_of(records))
    octopi = octopi || (input.scene == "octopi" && input.fnv1a.size() == 16 && !input.records.empty());
  EXPECT_TRUE(octopi);
  std::set<std::string> with_points;
  for (const json& record : points.at("columns").at("record"))
    with_points.insert(points.at("texts")[record.get<std::size_t>()].get<std::string>());
  EXPECT_EQ(1u, with_points.count("plus"));
  EXPECT_EQ(0u, with_points.count("operations")) << "no rows of the harness";
}

TEST(ReportRecords, PointsAreMediansOverRounds) {
  const test::ScratchFolder folder;
  json rows = json::array();
  for (const double seconds : {0.5, 0.1, 0.3})
    for (const int motion : {4, 5})
      rows.push_back({{"table", ""},
                      {"motion_model", "linear"},
                      {"pipeline", "P"},
                      {"scene", "s"},
                      {"step", motion},
                      {"seconds", seconds * motion},
                      {"vf_tests", 7},
                      {"narrow_phase_prepare_s", 0.25},
                      {"narrow_phase_run_s", 0.5},
                      {"threads", 1},
                      {"elements", 10}});
  std::ofstream(folder / "plus.json") << json{{"experiment", "plus"}, {"schema", 1}, {"rows", rows}};
  const json points = data_of_records(folder / "").points;
  const json& columns = points.at("columns");
  ASSERT_EQ(2u, columns.at("seconds").size());
  EXPECT_EQ(1.2, columns.at("seconds")[0]);
  EXPECT_EQ(0.4, columns.at("seconds_min")[0]);
  EXPECT_EQ(2.5, columns.at("seconds_max")[1]);
  EXPECT_EQ(3, columns.at("rounds")[0]);
  EXPECT_EQ(0.75, columns.at("narrow_phase_s")[1]);
  EXPECT_EQ("s", points.at("texts")[columns.at("scene")[0].get<std::size_t>()]);
}

TEST(ReportRecords, AFolderWithoutRecordsIsAnError) {
  const test::ScratchFolder folder;
  try {
    data_of_records(folder / "");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string::npos, std::string(error.what()).find("volccd experiment run"));
  }
}

}  // namespace
}  // namespace volccd
