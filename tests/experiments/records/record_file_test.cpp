// Records: a run continues the file of an interrupted one, ignores that of a different one, and a complete record
// replaces an old one.
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

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

/// Rows of one entrant on steps 3 and 4, with these seconds in the rounds.
std::vector<json> entrant_rows(const std::vector<double>& seconds, const json& other_columns = json::object()) {
  std::vector<json> rows;
  for (int step : {3, 4})
    for (std::size_t round = 0; round < seconds.size(); ++round) {
      rows.push_back({{"table", "c"},
                      {"scene", "s"},
                      {"motion_model", "linear"},
                      {"edges", "triangulated"},
                      {"shells", "surface"},
                      {"mesh", "whole"},
                      {"pipeline", "VolCCD"},
                      {"variant", ""},
                      {"threads", 1},
                      {"separation", 0.0},
                      {"step", step},
                      {"round", round},
                      {"seconds", seconds[round]},
                      {"topology_seconds", 0.0},
                      {"vf_tests", 1},
                      {"ee_tests", 2},
                      {"contacts_hash", "h"}});
      rows.back().update(other_columns);
    }
  return rows;
}

/// Two folders of records.
class CompareRecords : public ::testing::Test {
 protected:
  static void write(const std::string& folder, const std::vector<json>& rows, const std::string& name = "x") {
    std::filesystem::create_directories(folder);
    RecordFile record(folder, name, json::object());
    record.add("w", rows);
    record.finish(json::object(), json::array());
  }
  RecordComparison compared(const std::vector<json>& before, const std::vector<json>& after) const {
    write(a_, before);
    write(b_, after);
    return compare_records(a_, b_);
  }
  RecordComparison timed(const std::vector<double>& before, const std::vector<double>& after) const {
    return compared(entrant_rows(before), entrant_rows(after));
  }

  const ScratchFolder folder_;
  const std::string a_ = folder_ / "a", b_ = folder_ / "b";
};

TEST_F(CompareRecords, TimesBeyondTheToleranceOnly) {
  EXPECT_EQ(timed({1.00, 1.01, 1.02}, {1.10, 1.11, 1.12}).slower, 1u);
  EXPECT_EQ(timed({1.10, 1.11, 1.12}, {1.00, 1.01, 1.02}).faster, 1u);
  EXPECT_EQ(timed({1.00, 1.01, 1.02}, {1.01, 1.02, 1.03}).slower, 0u) << "within 3 %";
  EXPECT_EQ(timed({0.90, 1.00, 1.10}, {1.00, 1.11, 1.20}).slower, 0u) << "within the spread";
  EXPECT_THROW(compare_records(a_, folder_ / "absent"), InputError);
  EXPECT_THROW(timed({0.0}, {1.0}), InputError) << "no step takes no time";
}

/// What changes all entrants of a question alike is its drift; one that changes against the others is seen.
TEST_F(CompareRecords, ChangesAreAgainstTheOtherEntrantsOfTheQuestion) {
  std::vector<json> before, after, one_slower;
  for (const char* pipeline : {"NavCCD", "HashCCD", "VolCCD", "VolCCD+"}) {
    const auto add = [&](std::vector<json>& rows, double seconds) {
      const char* mesh = pipeline == std::string("HashCCD") ? "boundary" : "whole";  // both belong to one question
      for (const json& row : entrant_rows({seconds, 1.01 * seconds}, {{"pipeline", pipeline}, {"mesh", mesh}}))
        rows.push_back(row);
    };
    add(before, 1.0);
    add(after, 1.5);
    add(one_slower, pipeline == std::string("VolCCD+") ? 1.7 : 1.5);
  }
  const RecordComparison drifted = compared(before, after);
  EXPECT_EQ(0u, drifted.slower + drifted.faster);
  ASSERT_EQ(1u, drifted.drifts.size());
  EXPECT_NEAR(1.5, drifted.drifts[0].ratio, 1e-12);
  EXPECT_EQ(1u, compared(before, one_slower).slower);
  EXPECT_EQ(0u, compared(after, before).faster);
  std::vector<json> elsewhere = before;  // another scene does not excuse it
  for (json& row : elsewhere) row["scene"] = "t";
  std::vector<json> both = one_slower;
  both.insert(both.end(), elsewhere.begin(), elsewhere.end());
  before.insert(before.end(), elsewhere.begin(), elsewhere.end());
  EXPECT_EQ(1u, compared(before, both).slower);
}

/// A machine that has become slower changes all scenes alike.
TEST_F(CompareRecords, AScenesDriftIsAgainstThatOfTheOtherScenes) {
  const auto rows = [](const std::vector<double>& seconds_of_scenes) {
    std::vector<json> all;
    for (std::size_t scene = 0; scene < seconds_of_scenes.size(); ++scene)
      for (const char* pipeline : {"NavCCD", "VolCCD", "VolCCD+"})
        for (const json& row : entrant_rows({seconds_of_scenes[scene], 1.01 * seconds_of_scenes[scene]},
                                            {{"pipeline", pipeline}, {"scene", "s" + std::to_string(scene)}}))
          all.push_back(row);
    return all;
  };
  const std::vector<json> before = rows({1, 2, 3});
  EXPECT_EQ(1u, compared(before, rows({1, 2.6, 3})).slower);
  EXPECT_EQ(1u, compared(rows({1, 2.6, 3}), before).faster);
  EXPECT_EQ(0u, compared(before, rows({1, 2.4, 3})).slower);
  EXPECT_EQ(0u, compared(before, rows({1.5, 3, 4.5})).slower);
  EXPECT_EQ(1u, compared(before, rows({1.5, 3, 6})).slower);
  EXPECT_EQ(0u, compared(rows({1, 2, 3, 4}), rows({1, 2, 4.2, 5.6})).faster) << "1 and 1.4 times, of two scenes each";
}

/// The factors that the help text promises to see.
TEST_F(CompareRecords, EveryRiseBeyondTheGreatestToleranceIsSeen) {
  for (const std::vector<double>& rounds : std::vector<std::vector<double>>{
           {1.0}, {1.0, 1.0}, {1.0, 1.02, 1.01}, {0.5, 1.0, 1.5}, {1.0, 1.0, 100.0}, {0.001, 0.002}})
    for (const double factor : {1.26, 1.3, 1.5, 2.0, 100.0}) {
      std::vector<double> after = rounds;
      for (double& seconds : after) seconds *= factor;
      const RecordComparison result = timed(rounds, after);
      EXPECT_EQ(result.slower, 1u) << rounds.size() << " rounds, factor " << factor;
      EXPECT_EQ(result.single, rounds.size() == 1 ? 1u : 0u);
      EXPECT_EQ(timed(after, rounds).faster, 1u);
    }
  EXPECT_EQ(timed({1.0}, {1.24}).slower, 0u) << "a single round";
  for (const double factor : {1.04, 1.1}) EXPECT_EQ(timed({1.0, 1.01}, {factor, 1.01 * factor}).slower, 1u) << factor;
}

/// A row differs from all others in one column only, and its entrant alone is slower.
TEST_F(CompareRecords, EveryColumnThatTellsRowsApart) {
  for (const auto& [column, value] : std::map<std::string, json>{{"table", "d"},
                                                                 {"scene", "t"},
                                                                 {"motion_model", "quadratic"},
                                                                 {"edges", "polytope"},
                                                                 {"shells", "solid"},
                                                                 {"mesh", "boundary"},
                                                                 {"pipeline", "NavCCD"},
                                                                 {"variant", "k=6"},
                                                                 {"threads", 2},
                                                                 {"separation", 0.5}}) {
    std::vector<json> before = entrant_rows({1.0, 1.01}), after = before;
    for (const json& row : entrant_rows({9.0, 9.1}, {{column, value}})) before.push_back(row);
    for (const json& row : entrant_rows({9.9, 10.0}, {{column, value}})) after.push_back(row);
    const RecordComparison result = compared(before, after);
    EXPECT_EQ(result.compared, 2u) << column;
    EXPECT_EQ(result.slower, 1u) << column;
    EXPECT_TRUE(result.only_on_one_side.empty()) << column;
  }
  std::vector<json> twice = entrant_rows({1.0}, {{"other", 1}});
  for (const json& row : entrant_rows({1.0}, {{"other", 2}})) twice.push_back(row);
  EXPECT_THROW(compared(twice, twice), InputError) << "no known column tells these rows apart";
}

TEST_F(CompareRecords, Counts) {
  for (const json& other : {json{{"contacts_hash", "i"}}, json{{"vf_tests", 2}}, json{{"ee_tests", 3}}})
    EXPECT_EQ(compared(entrant_rows({1.0, 1.0}), entrant_rows({1.0, 1.0}, other)).other_counts, 1u) << other;
}

TEST_F(CompareRecords, SaysWhatOneSideAloneHas) {
  const std::vector<json> one = entrant_rows({1.0, 1.0});
  std::vector<json> two = one, half = one;
  for (const json& row : entrant_rows({1.0, 1.0}, {{"threads", 2}})) two.push_back(row);
  half.resize(2);  // step 3
  EXPECT_EQ(compared(two, one).only_on_one_side,
            std::vector<std::string>{"x, entrants c s VolCCD threads=2: only in A"});
  EXPECT_EQ(compared(one, two).only_on_one_side,
            std::vector<std::string>{"x, entrants c s VolCCD threads=2: only in B"});
  EXPECT_EQ(compared(half, one).only_on_one_side,
            std::vector<std::string>{"x, c s VolCCD threads=1, steps 4: only in B"});
  write(a_, {json{{"operation", "csat"}}}, "operations");
  EXPECT_EQ(compared(one, one).only_on_one_side, std::vector<std::string>{"record operations: only in A"});
  write(b_, {json{{"operation", "csat"}}}, "operations");
  const RecordComparison result = compared(one, one);
  EXPECT_TRUE(result.only_on_one_side.empty());
  EXPECT_EQ(result.without_times, std::vector<std::string>{"operations"});
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
