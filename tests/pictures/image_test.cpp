// Images: PNG files, and text in them.
#include <volccd/pictures/image.hpp>

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <png.h>

#include <volccd/core/error.hpp>
#include <volccd/pictures/text.hpp>

#include "support/scratch_folder.hpp"

/// Fontconfig keeps data about fonts until the process ends, and the leak sanitizer reports a part of them.
extern "C" const char* __lsan_default_suppressions();
const char* __lsan_default_suppressions() { return "leak:libfontconfig\n"; }

namespace volccd {
namespace {

TEST(PictureFiles, LibpngReadsWhatWasDrawn) {
  const test::ScratchFolder folder;
  const std::string file = folder / "picture.png";
  Image image(37, 23);
  for (int y = 0; y < 23; ++y)
    for (int x = 0; x < 37; ++x)
      image.set(
          x, y,
          {static_cast<std::uint8_t>(7 * x), static_cast<std::uint8_t>(11 * y), static_cast<std::uint8_t>(x * y)});
  write_png(image, file);
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  ASSERT_TRUE(png_image_begin_read_from_file(&header, file.c_str()));
  EXPECT_EQ(header.width, 37u);
  EXPECT_EQ(header.height, 23u);
  header.format = PNG_FORMAT_RGB;
  std::vector<Colour> read(PNG_IMAGE_SIZE(header) / 3);
  ASSERT_TRUE(png_image_finish_read(&header, nullptr, read.data(), 0, nullptr));
  EXPECT_TRUE(std::equal(read.begin(), read.end(), image.pixels().begin(), image.pixels().end()));
  EXPECT_THROW(write_png(image, "/nonexistent/picture.png"), InputError);
  EXPECT_THROW(Image(0, 5), ConfigError);
  EXPECT_THROW(Image(20000, 20000), ConfigError);
}

TEST(PictureText, FillsTheWidthItSays) {
  Image image(400, 60);
  const std::string text = "Plate 12.5 (m/s)";
  draw_text(image, text, 20, 40, 18, {0, 0, 0});
  int left = 400, right = 0, top = 60, bottom = 0;
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 400; ++x)
      if (image.at(x, y).r < 128) {
        left = std::min(left, x);
        right = std::max(right, x);
        top = std::min(top, y);
        bottom = std::max(bottom, y);
      }
  EXPECT_NEAR(left, 20, 2);
  EXPECT_NEAR(right, 20 + text_width(text, 18), 5);
  EXPECT_NEAR(top, 40 - 18 - 1, 2);  // the parentheses
  EXPECT_NEAR(bottom, 40 + 3, 2);
  EXPECT_EQ(text_width("\xC3\xA4", 12), text_width("a", 12));  // a with dots
  EXPECT_EQ(text_width("\xFF\xE0\x80", 12), text_width("???", 12));
}

TEST(PictureText, LosesNothingAtTheEndsOfLines) {
  EXPECT_EQ(wrap_text("short", 12, 1000), std::vector<std::string>{"short"});
  EXPECT_EQ(wrap_text("", 12, 1000), std::vector<std::string>{""});
  const std::string text = "rather a long text with an extraordinarilylongword";
  const std::vector<std::string> lines = wrap_text(text, 12, 60);
  EXPECT_GT(lines.size(), 5u);
  std::string letters, all;
  for (const std::string& line : lines) {
    EXPECT_LE(text_width(line, 12), 60) << line;
    all += line;
  }
  for (const char c : text)
    if (c != ' ') letters += c;
  std::erase(all, ' ');
  EXPECT_EQ(all, letters);
}

}  // namespace
}  // namespace volccd
