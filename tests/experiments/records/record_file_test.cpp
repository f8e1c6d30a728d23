// Records: a run continues the file of an interrupted one, ignores that of a different one, and a complete record
// replaces an old one.
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/experiments/records/record_file.hpp>
#include <volccd/experiments/tables/compare_records.hpp>

#include "support/scratch_folder.hpp"

namespace volccd::test {
namespace {

using nlohmann::json;

const json kIdentity = {{"plan", "p"}, {"commit", "c"}};

TEST(RecordFile, GoesOnWithWhatIsThere) {
  const ScratchFolder folder;
  {
    RecordFile record(folder / "", "x", kIdentity);
    record.add("first", {json{{"n", 1}}, json{{"n", 2}}});
    record.add("second", {json{{"n", 3}}});
  }
  // the interruption is here
  std::ofstream(folder / "x.incomplete.jsonl", std::ios::app) << "{\"key\": \"third\", \"rows\": [{\"n\"";
  RecordFile record(folder / "", "x", kIdentity);
  EXPECT_EQ(record.resumed(), 2u);
  EXPECT_TRUE(record.has("first") && record.has("second") && !record.has("third"));
  EXPECT_EQ(record.rows().size(), 3u);
  record.add("third", {json{{"n", 4}}});
  EXPECT_FALSE(std::filesystem::exists(record.file())) << "an incomplete record must not take the place of a whole one";
  record.finish({{"commit", "c"}}, json::array({json{{"s", 1}}}));
  EXPECT_FALSE(std::filesystem::exists(record.incomplete_file()));
  const json whole = read_record(record.file());
  ASSERT_EQ(whole.at("rows").size(), 4u);
  EXPECT_EQ(whole.at("rows")[3].at("n"), 4);
  EXPECT_EQ(whole.at("summary")[0].at("s"), 1);
  EXPECT_EQ(whole.at("experiment"), "x");
  EXPECT_EQ(whole.at("complete"), true);
}

TEST(RecordFile, RowsOfAnotherRunAreNotTakenUp) {
  const ScratchFolder folder;
  { RecordFile(folder / "", "x", kIdentity).add("first", {json{{"n", 1}}}); }
  RecordFile record(folder / "", "x", {{"plan", "p"}, {"commit", "d"}});
  EXPECT_TRUE(record.set_aside());
  EXPECT_NE(text_of(record.old_file()).find("first"), std::string::npos) << "rows that took hours must not be gone";
  EXPECT_EQ(record.resumed(), 0u);
  EXPECT_TRUE(record.rows().empty());
}

TEST(RecordFile, AWholeRecordStaysUntilTheNextIsWhole) {
  const ScratchFolder folder;
  {
    RecordFile record(folder / "", "x", kIdentity);
    record.add("first", {json{{"n", 1}}});
    record.finish(json::object(), json::array());
  }
  const std::string before = text_of(folder / "x.json");
  RecordFile record(folder / "", "x", kIdentity);
  record.add("first", {json{{"n", 2}}});
  EXPECT_EQ(text_of(folder / "x.json"), before);
}

/// A record of one entrant on one motion with these seconds, one value for each round.
void write_record(const std::string& folder, const std::vector<double>& seconds, const std::string& contacts) {
  std::filesystem::create_directories(folder);
  std::vector<json> rows;
  for (const double s : seconds)
    rows.push_back({{"table", "c"},
                    {"scene", "s"},
                    {"motion_model", "linear"},
                    {"edges", "triangulated"},
                    {"pipeline", "VolCCD"},
                    {"variant", ""},
                    {"motion", 3},
                    {"seconds", s},
                    {"topology_seconds", 0.0},
                    {"vf_tests", 1},
                    {"ee_tests", 2},
                    {"contacts_hash", contacts}});
  RecordFile record(folder, "x", json::object());
  record.add("w", rows);
  record.finish(json::object(), json::array());
}

TEST(CompareRecords, JudgesBeyondTheSpreadOnly) {
  const ScratchFolder folder;
  const std::string a = folder / "a", b = folder / "b";
  const auto changed = [&](const std::vector<double>& before, const std::vector<double>& after,
                           const char* hash = "h") {
    write_record(a, before, "h");
    write_record(b, after, hash);
    return compare_records(a, b);
  };
  EXPECT_EQ(changed({1.00, 1.01, 1.02}, {1.10, 1.11, 1.12}).slower, 1u);
  EXPECT_EQ(changed({1.10, 1.11, 1.12}, {1.00, 1.01, 1.02}).faster, 1u);
  EXPECT_EQ(changed({1.00, 1.01, 1.02}, {1.01, 1.02, 1.03}).slower, 0u) << "within 3 %";
  EXPECT_EQ(changed({0.90, 1.00, 1.10}, {1.00, 1.11, 1.20}).slower, 0u) << "within the spread";
  EXPECT_EQ(changed({1.00}, {2.00}).slower, 0u);
  EXPECT_EQ(changed({1.00}, {2.00}).single, 1u);
  EXPECT_EQ(changed({1.00, 1.00}, {1.00, 1.00}, "other").other_counts, 1u);
  EXPECT_THROW(compare_records(a, folder / "absent"), InputError);
}

TEST(RecordFile, RefusesWhatIsNoRecord) {
  const ScratchFolder folder;
  EXPECT_THROW(read_record(folder / "absent.json"), InputError);
  std::ofstream(folder / "other.json") << "{\"rows\": [], \"experiment\": \"x\", \"schema\": 0}";
  EXPECT_THROW(read_record(folder / "other.json"), InputError);
  std::ofstream(folder / "list.json") << "[1]";
  EXPECT_THROW(read_record(folder / "list.json"), InputError);
  EXPECT_THROW(RecordFile("/proc/no", "x", kIdentity), InputError);
}

}  // namespace
}  // namespace volccd::test
