// Text files of steps: complete steps are kept, and the file is marked if steps are missing.
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/io/contacts_csv.hpp>
#include <volccd/io/step_text.hpp>

#include "support/full_disk.hpp"
#include "support/scratch_folder.hpp"

namespace volccd::test {
namespace {

TEST(StepText, SaysWhichStepsAreComplete) {
  EXPECT_EQ((StepsDone{2, 7, 21, "interrupted"}).text(), "steps 2 to 6 of 2 to 20 are complete; interrupted");
  EXPECT_EQ((StepsDone{0, 0, 21, "no memory"}).text(), "no step of 0 to 20 is complete; no memory");
  EXPECT_EQ((StepsDone{0, 4, 4, ""}).text(), "steps 0 to 3 of 0 to 3 are complete");
}

TEST(StepText, KeepsCompleteStepsAndMarksThem) {
  const ScratchFolder folder;
  StepTextWriter writer(folder / "a", "step,x");
  writer.write_step(3, "3,1\n3,2\n");
  writer.write_step(4, "");
  writer.write_step(5, "5,1\n");
  EXPECT_THROW(writer.write_step(5, ""), InputError);
  EXPECT_FALSE(std::filesystem::exists(folder / "a"));
  const StepsDone kept = writer.finish_incomplete({3, 5, 9, "run.vtkhdf: VTKHDF/Points[7, 2]:\n\"bad\""});
  EXPECT_EQ(kept.done, 5);
  EXPECT_EQ(
      text_of(folder / "a"),
      "step,x\n3,1\n3,2\n# incomplete: steps 3 to 4 of 3 to 8 are complete; run.vtkhdf: VTKHDF/Points[7; 2]: 'bad'\n");
  EXPECT_THROW(writer.finish(), InputError);
}

TEST(StepText, WithoutACompleteStepTheOldFileStays) {
  const ScratchFolder folder;
  write_text_file(folder / "a", "old");
  {
    StepTextWriter writer(folder / "a", "step,x");
    EXPECT_EQ(writer.finish_incomplete({0, 0, 9, "interrupted"}).done, 0);
  }
  EXPECT_EQ(text_of(folder / "a"), "old");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(StepText, OnAFullDiskTheStepsThatFitAreKept) {
  const ScratchFolder folder;
  const std::string row = std::string(49, 'x') + "\n";
  StepTextWriter writer(folder / "a", "step");
  const FullDisk disk(5 + 4 * 50 + 5);  // four steps would fit, but the mark needs the space of two
  for (int step = 0; step < 4; ++step) writer.write_step(step, row);
  EXPECT_THROW(writer.write_step(4, row), InputError);
  EXPECT_EQ(writer.finish_incomplete({0, 4, 9, "disk full"}).done, 2);
  EXPECT_EQ(text_of(folder / "a"),
            "step\n" + row + row + "# incomplete: steps 0 to 1 of 0 to 8 are complete; disk full\n");
}

TEST(StepText, AStepThatFailsLeavesNoRows) {
  const ScratchFolder folder;
  StepTextWriter writer(folder / "a", "step");
  writer.write_step(0, "0\n");
  {
    const FullDisk disk(9);
    EXPECT_THROW(writer.write_step(1, "1\n1\n1\n"), InputError);
  }
  writer.write_step(1, "1\n");
  writer.finish();
  EXPECT_EQ(text_of(folder / "a"), "step\n0\n1\n");
}

TEST(StepText, StreamsAreMarkedToo) {
  const ScratchFolder folder;
  std::FILE* const file = std::fopen((folder / "a").c_str(), "w");
  {
    StepTextWriter writer("/dev/fd/" + std::to_string(::fileno(file)), "step");
    EXPECT_EQ(text_of(folder / "a"), "") << "a header alone would say that there are no rows";
    writer.write_step(0, "0\n");
    EXPECT_EQ(text_of(folder / "a"), "step\n0\n");
    writer.finish_incomplete({0, 1, 9, "interrupted"});
  }
  std::fclose(file);
  EXPECT_EQ(text_of(folder / "a"), "step\n0\n# incomplete: steps 0 to 0 of 0 to 8 are complete; interrupted\n");
}

TEST(StepText, ContactsReaderToldOfTheMark) {
  const ScratchFolder folder;
  Mesh mesh;
  mesh.add_vertices(std::vector<std::int64_t>{0, 1, 2, 3});
  const std::vector<Contact> contacts = {{FeatureKind::vf, {0, 1, 2, 3}, 0, Vec3::Zero(), {}, Vec3::Zero(), true}};
  ContactsCsvWriter writer(folder / "c.csv");
  writer.write_step(0, contacts, mesh);
  writer.write_step(1, contacts, mesh);
  writer.finish_incomplete({0, 2, 5, "interrupted"});
  try {
    read_contacts_csv(folder / "c.csv");
    FAIL() << "an incomplete file is refused";
  } catch (const InputError& error) {
    EXPECT_EQ(error.index(), 4);
    EXPECT_NE(std::string(error.what()).find("steps 0 to 1 of 0 to 4 are complete; interrupted"), std::string::npos);
  }
  std::string incomplete;
  const std::vector<ContactRow> rows = read_contacts_csv(folder / "c.csv", &incomplete);
  EXPECT_EQ(incomplete, "steps 0 to 1 of 0 to 4 are complete; interrupted");
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_TRUE(rows[1].at_start);
  std::ofstream(folder / "c.csv", std::ios::app) << "2,VF,0,1,2,3,0,0,0,0,0,0,0,1,0,0,0,0\n";
  EXPECT_THROW(read_contacts_csv(folder / "c.csv", &incomplete), InputError) << "a row after the mark";
}

}  // namespace
}  // namespace volccd::test
