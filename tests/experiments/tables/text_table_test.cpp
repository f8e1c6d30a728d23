// Tables and texts within the width of a terminal.
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include <volccd/experiments/tables/text_table.hpp>

namespace volccd::test {
namespace {

std::size_t widest(const std::string& text) {
  std::size_t width = 0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) width = std::max(width, line.size());
  return width;
}

TEST(TextTable, NarrowOnesStayAsTheyAre) {
  TextTable table({"step", "element pairs", "t"});
  table.add({"0", "12", "0.5"});
  EXPECT_EQ(table.text(),
            "step  element pairs    t\n"
            "------------------------\n"
            "0                12  0.5\n");
}

TEST(TextTable, HeadersBreakWhereARowIsTooWide) {
  TextTable table({"step", std::string(60, 'a') + " bb", std::string(30, 'c') + " dd ee"});
  table.add({"0", "1", "2"});
  const std::string text = table.text();
  const std::string a(60, 'a'), c(30, 'c');
  EXPECT_EQ(text, std::string(7, ' ') + a + "   " + c + "\n" + "step" + std::string(61, ' ') + "bb" +
                      std::string(28, ' ') + "dd ee\n" + std::string(100, '-') + "\n" + "0" + std::string(65, ' ') +
                      "1" + std::string(32, ' ') + "2\n");
}

/// The labels are repeated, and no column is lost.
TEST(TextTable, ColumnsThatDoNotFitFollowBelow) {
  std::vector<std::string> header = {"scene", "motion"}, row = {"octopi", "linear"};
  for (int c = 0; c < 12; ++c) {
    header.push_back("c" + std::to_string(c));
    row.push_back(std::string(14, static_cast<char>('a' + c)));
  }
  TextTable table(header, 2);
  table.add(row);
  table.rule();
  const std::string text = table.text();
  EXPECT_LE(widest(text), kTextWidth);
  for (const std::string& cell : row) EXPECT_NE(text.find(cell), std::string::npos) << cell;
  std::size_t labels = 0;
  for (std::size_t at = 0; (at = text.find("octopi  linear", at)) != std::string::npos; ++at) ++labels;
  EXPECT_EQ(labels, 3u) << text;
  EXPECT_EQ(table.csv().find('\n'), table.csv().find("\noctopi")) << "one table for programs";
}

TEST(TextTable, ACellThatIsWiderByItselfStays) {
  TextTable table({"name", "x"});
  table.add({std::string(150, 'n'), "1"});
  EXPECT_NE(table.text().find(std::string(150, 'n')), std::string::npos);
}

TEST(TextTable, ANarrowerTerminalTakesMoreTables) {
  TextTable table({"name", "one", "two", "three"});
  table.add({"a", "1", "2", "3"});
  EXPECT_EQ(table.text(15),
            "name  one  two\n--------------\na       1    2\n\nname  three\n-----------\na         3\n");
  EXPECT_EQ(table.text(100), table.text());
}

TEST(TextTable, Numbers) {
  EXPECT_EQ(number_text(0), "0");
  EXPECT_EQ(number_text(0.012345), "0.0123");
  EXPECT_EQ(number_text(999.4), "999");
  EXPECT_EQ(number_text(999.5), "1,000");
  EXPECT_EQ(number_text(1139.6), "1,140");
  EXPECT_EQ(number_text(-28900.4), "-28,900");
  EXPECT_EQ(fixed_text(-0.04, 1), "0.0");
  EXPECT_EQ(fixed_text(-0.4, 0), "0");
  EXPECT_EQ(fixed_text(-0.06, 1), "-0.1");
  EXPECT_EQ(counted(1, "step"), "1 step");
  EXPECT_EQ(counted(1234, "step"), "1,234 steps");
  EXPECT_EQ(counted(0, "step"), "0 steps");
}

TEST(TextTable, Wrapped) {
  EXPECT_EQ(wrapped("one two three", 7), "one two\nthree");
  EXPECT_EQ(wrapped("  one two three\nfour", 9), "  one two\n  three\nfour");
  EXPECT_EQ(wrapped("unbreakable text", 4), "unbreakable\ntext");
  EXPECT_EQ(wrapped("", 4), "");
  EXPECT_EQ(wrapped("a\n\nb\n", 10), "a\n\nb\n");
}

TEST(TextTable, Labelled) {
  EXPECT_EQ(labelled("  name", "text", 8), "  name  text\n");
  EXPECT_EQ(labelled("  a-long-name", "text", 8), "  a-long-name\n        text\n");
  const std::string lines = labelled("n", std::string(60, 'a') + " " + std::string(60, 'b'), 10);
  EXPECT_EQ(lines, "n         " + std::string(60, 'a') + "\n          " + std::string(60, 'b') + "\n");
}

}  // namespace
}  // namespace volccd::test
