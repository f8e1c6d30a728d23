// The folder of a report: its contents during and after an interruption.
#include <volccd/report/page_files.hpp>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>

#include <gtest/gtest.h>

#include <unistd.h>

#include <volccd/core/error.hpp>

namespace volccd {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

/// A page of a few words in a folder of this test, and a report beside it.
class ReportFolderTest : public ::testing::Test {
 protected:
  ReportFolderTest() : root_(fs::temp_directory_path() / ("volccd-report-folder-" + std::to_string(getpid()))) {
    write("page/index.html", "<nav><!-- parts --></nav><!-- contents -->");
    write("page/volccd.css", "style");
    write("page/volccd.js", "script");
    if (const char* before = std::getenv("VOLCCD_PAGE")) page_before_ = before;
    setenv("VOLCCD_PAGE", (root_ / "page").c_str(), 1);
  }
  ~ReportFolderTest() override {
    if (page_before_)
      setenv("VOLCCD_PAGE", page_before_->c_str(), 1);
    else
      unsetenv("VOLCCD_PAGE");
    std::error_code ignored;
    fs::remove_all(root_, ignored);
  }

  std::string path(const std::string& name) const { return (root_ / name).string(); }

  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((root_ / name).parent_path());
    std::ofstream(root_ / name) << text;
  }

  /// The texts of all files in a folder, by their paths.
  std::map<std::string, std::string> files(const std::string& folder) const {
    std::map<std::string, std::string> texts;
    for (const auto& entry : fs::recursive_directory_iterator(root_ / folder)) {
      if (!entry.is_regular_file()) continue;
      std::ifstream in(entry.path());
      texts[fs::relative(entry.path(), root_ / folder).string()] = {std::istreambuf_iterator<char>(in), {}};
    }
    return texts;
  }

  static json report(const std::string& scene) {
    return {{"records", {{{"name", "table1"}, {"description", "Times & counts"}}}},
            {"scenes", {{{"name", scene}}, {{"name", "absent"}, {"missing", "a command"}}}}};
  }

  void make_first() const {
    ReportFolder folder(path("report"));
    folder.write_scene("one", "first");
    folder.finish(report("one"));
  }

 private:
  fs::path root_;
  std::optional<std::string> page_before_;
};

TEST_F(ReportFolderTest, FinishReplacesAnEarlierReport) {
  make_first();
  write("report/data/own.txt", "not of the report");
  ReportFolder folder(path("report"));
  EXPECT_EQ("data/scene-two.js", folder.write_scene("two", "second"));
  const std::size_t bytes = folder.finish(report("two"));
  const auto now = files("report");
  std::size_t sum = 0;
  for (const auto& [name, text] : now) sum += text.size();
  EXPECT_EQ(sum, bytes);
  ASSERT_EQ(6u, now.size());
  EXPECT_EQ("second", now.at("data/scene-two.js"));
  EXPECT_EQ("not of the report", now.at("data/own.txt"));
  EXPECT_NE(std::string::npos, now.at("data/report.js").find("two"));
  EXPECT_FALSE(fs::exists(path("report/.volccd-unfinished")));
}

TEST_F(ReportFolderTest, TheFirstPictureNamesRecordsAndScenes) {
  make_first();
  const std::string index = files("report").at("index.html");
  for (const char* part :
       {"<a href=\"#tables\">Tables</a>", "<a href=\"#tables/table1\">table1</a>: Times &amp; counts.",
        "<a href=\"#scenes/one\">one</a>"})
    EXPECT_NE(std::string::npos, index.find(part)) << part << index;
  EXPECT_EQ(std::string::npos, index.find("absent"));
}

TEST_F(ReportFolderTest, AnInterruptedReportLeavesTheEarlierOneAsItWas) {
  make_first();
  const auto before = files("report");
  {
    ReportFolder folder(path("report"));
    folder.write_scene("one", "second");
    for (const auto& [name, text] : before) EXPECT_EQ(text, files("report").at(name)) << name;
  }
  EXPECT_EQ(before, files("report"));
  EXPECT_FALSE(fs::exists(path("report/.volccd-unfinished")));
}

TEST_F(ReportFolderTest, AnInterruptedFirstReportLeavesNothing) {
  { ReportFolder(path("report")).write_scene("one", "first"); }
  EXPECT_FALSE(fs::exists(path("report")));
}

TEST_F(ReportFolderTest, AReportThatWasKilledCanBeMadeAgain) {
  for (const bool earlier : {false, true}) {
    fs::remove_all(path("report"));
    fs::remove_all(path("killed"));
    if (earlier) make_first();
    {
      ReportFolder folder(path("report"));
      folder.write_scene("two", "second");
      fs::copy(path("report"), path("killed"), fs::copy_options::recursive);
    }
    ReportFolder again(path("killed"));
    again.write_scene("three", "third");
    again.finish(report("three"));
    const auto now = files("killed");
    EXPECT_EQ(5u, now.size());
    EXPECT_EQ("third", now.at("data/scene-three.js"));
  }
}

TEST_F(ReportFolderTest, OldDataThatCannotBeRemovedAreAnError) {
  make_first();
  fs::remove(path("report/data/report.js"));
  write("report/data/report.js/own.txt", "a folder in the place of the file");
  const auto before = files("report");
  {
    ReportFolder folder(path("report"));
    folder.write_scene("one", "second");
    try {
      folder.finish(report("one"));
      FAIL() << "no error";
    } catch (const InputError& error) {
      const std::string text = error.what();
      EXPECT_NE(std::string::npos, text.find("data/report.js")) << text;
      EXPECT_NE(std::string::npos, text.find("cannot be removed")) << text;
    }
  }
  EXPECT_EQ(before, files("report"));
}

TEST_F(ReportFolderTest, ThePageIsNotOverwritten) {
  const auto before = files("page");
  fs::create_directory_symlink(path("page"), path("link"));
  for (const char* name : {"page", "page/", "link", "page/../page"})
    EXPECT_THROW(ReportFolder(path(name)), InputError) << name;
  EXPECT_EQ(before, files("page"));
  EXPECT_FALSE(fs::exists(path("page/.volccd-unfinished")));
}

TEST_F(ReportFolderTest, AFolderWithOtherFilesIsAnError) {
  write("mine/text.txt", "mine");
  write("mine/unfinished/text.txt", "mine");
  EXPECT_THROW(ReportFolder(path("mine")), InputError);
  EXPECT_EQ(2u, files("mine").size());
  EXPECT_FALSE(fs::exists(path("mine/.volccd-unfinished")));
}

}  // namespace
}  // namespace volccd
