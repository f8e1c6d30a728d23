// Records: what a run left is taken up, what belongs to another run is not, and a whole record replaces an old one.
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/experiments/records/record_file.hpp>

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
  std::ofstream(folder / "x.incomplete.jsonl", std::ios::app) << "{\"key\": \"third\", \"rows\": [{\"n\"";  // cut here
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
  EXPECT_TRUE(record.replaced());
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
