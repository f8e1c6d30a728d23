// Outputs are complete or absent; links, FIFOs and devices are kept; errors name the file and the reason.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include <volccd/core/error.hpp>
#include <volccd/io/output_file.hpp>

#include "support/full_disk.hpp"

namespace volccd::test {
namespace {

namespace fs = std::filesystem;

class OutputFiles : public ::testing::Test {
 protected:
  OutputFiles() {
    std::string name = (fs::temp_directory_path() / "volccd-output-XXXXXX").string();
    if (!::mkdtemp(name.data())) throw std::runtime_error("no scratch folder");
    folder_ = name;
  }
  ~OutputFiles() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::ptrdiff_t entries() const { return std::distance(fs::directory_iterator(folder_), {}); }

  static std::string text_of(const std::string& file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  /// The message of the error for an output of this name.
  static std::string refusal(const std::string& name, const char* only_files = nullptr) {
    try {
      check_output(name, only_files);
    } catch (const InputError& error) {
      EXPECT_EQ(error.source(), name);
      return error.what();
    }
    return "";
  }

  fs::path folder_;
};

TEST_F(OutputFiles, WholeOrNotAtAll) {
  write_text_file(path("a"), "old");
  {
    OutputFile file(path("a"));
    file.write("new");
    EXPECT_EQ(text_of(path("a")), "old");
    EXPECT_EQ(entries(), 2);
  }
  EXPECT_EQ(text_of(path("a")), "old");
  EXPECT_EQ(entries(), 1);
  OutputFile file(path("a"));
  file.write("new and ");
  const std::int64_t size = file.size();
  file.write("too much");
  file.truncate(size);
  file.write("whole");
  file.commit();
  EXPECT_EQ(text_of(path("a")), "new and whole");
  EXPECT_EQ(entries(), 1);
}

TEST_F(OutputFiles, PermissionsOfTheReplacedFileStay) {
  write_text_file(path("a"), "old");
  ASSERT_EQ(::chmod(path("a").c_str(), 0640), 0);
  write_text_file(path("a"), "new");
  EXPECT_EQ(fs::status(path("a")).permissions(), fs::perms(0640));
}

TEST_F(OutputFiles, LinksStayAndTheirTargetIsReplaced) {
  fs::create_directory(path("b"));
  fs::create_symlink("b/there", path("link"));  // relative to the link's folder; the file does not exist yet
  fs::create_symlink(path("link"), path("link-to-link"));
  write_text_file(path("link-to-link"), "one");
  EXPECT_EQ(text_of(path("b/there")), "one");
  write_text_file(path("link"), "two");
  EXPECT_EQ(text_of(path("b/there")), "two");
  EXPECT_TRUE(fs::is_symlink(path("link")));
  EXPECT_TRUE(fs::is_symlink(path("link-to-link")));
  EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(path("b/there"))));
}

TEST_F(OutputFiles, FifosAndDevicesAreWrittenThrough) {
  ASSERT_EQ(::mkfifo(path("fifo").c_str(), 0600), 0);
  char bytes[8] = {};
  const int fifo = ::open(path("fifo").c_str(), O_RDONLY | O_NONBLOCK);
  write_text_file(path("fifo"), "through");
  EXPECT_EQ(::read(fifo, bytes, 7), 7);
  EXPECT_STREQ(bytes, "through");
  ::close(fifo);
  EXPECT_TRUE(fs::is_fifo(path("fifo")));
  // Uses a terminal of the test's own, so that an error cannot damage /dev/null.
  const int terminal = ::posix_openpt(O_RDWR | O_NOCTTY);
  if (terminal < 0 || ::grantpt(terminal) != 0 || ::unlockpt(terminal) != 0) GTEST_SKIP() << "no terminals here";
  const std::string device = ::ptsname(terminal);
  fs::create_symlink(device, path("device"));
  const int keeps_it_open = ::open(device.c_str(), O_RDWR | O_NOCTTY);
  write_text_file(path("device"), "as well");
  ::fcntl(terminal, F_SETFL, O_NONBLOCK);
  EXPECT_EQ(::read(terminal, bytes, 7), 7);
  EXPECT_STREQ(bytes, "as well");
  EXPECT_TRUE(fs::is_symlink(path("device")));
  EXPECT_TRUE(fs::is_character_file(path("device")));
  EXPECT_EQ(entries(), 2);
  ::close(keeps_it_open);
  ::close(terminal);
}

TEST_F(OutputFiles, DescriptorsAreWrittenTo) {
  // A shell's `>` opens a regular file behind a descriptor; renaming another file over it would lose the output.
  const int descriptor = ::open(path("a").c_str(), O_CREAT | O_WRONLY, 0600);
  ASSERT_GE(descriptor, 0);
  fs::create_symlink("/dev/fd/" + std::to_string(descriptor), path("link"));
  write_text_file("/dev/fd/" + std::to_string(descriptor), "one ");
  write_text_file("/proc/self/fd/" + std::to_string(descriptor), "two ");
  write_text_file(path("link"), "three");
  ::close(descriptor);
  EXPECT_EQ(text_of(path("a")), "one two three");
  EXPECT_EQ(entries(), 2);
  for (const char* name : {"-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"})
    EXPECT_TRUE(is_standard_output(name)) << name;
  for (const char* name : {"/dev/stderr", "/dev/null", "./-", ""}) EXPECT_FALSE(is_standard_output(name)) << name;
}

TEST_F(OutputFiles, RefusalsNameTheFileAndTheReason) {
  fs::create_symlink(path("y"), path("x"));
  fs::create_symlink(path("x"), path("y"));
  write_text_file(path("a"), "old");
  EXPECT_NE(refusal(path("no/such")).find("No such file or directory"), std::string::npos);
  EXPECT_NE(refusal(path("a/b")).find("Not a directory"), std::string::npos);
  EXPECT_NE(refusal(path("x")).find("links"), std::string::npos);
  EXPECT_NE(refusal(folder_.string()).find("folder"), std::string::npos);
  EXPECT_THROW(output_target(""), InputError);
  ASSERT_EQ(::mkfifo(path("fifo").c_str(), 0600), 0);
  for (const std::string& name : {std::string("-"), path("fifo")})
    EXPECT_NE(refusal(name, "it needs a file").find("is not a regular file: it needs a file"), std::string::npos);
  EXPECT_EQ(refusal(path("fifo")), "") << "a check does not wait for a reader";
  EXPECT_EQ(refusal(path("b"), "it needs a file"), "");
  EXPECT_EQ(entries(), 4) << "a check leaves nothing behind";
}

TEST_F(OutputFiles, AFullDiskLeavesTheOldFile) {
  write_text_file(path("a"), "old");
  std::string message;
  try {
    const FullDisk disk(100);
    write_text_file(path("a"), std::string(200, 'x'));
  } catch (const InputError& error) {
    message = error.what();
  }
  EXPECT_EQ(message, path("a") + ": cannot be written: File too large");
  EXPECT_EQ(text_of(path("a")), "old");
  EXPECT_EQ(entries(), 1);
}

}  // namespace
}  // namespace volccd::test
