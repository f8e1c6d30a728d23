// Texts and numbers in the scripts of a report.
#include <volccd/report/encoding.hpp>

#include <volccd/core/random.hpp>

#include "report/decode_script.hpp"

namespace volccd {
namespace {

TEST(ReportEncoding, Base64IsThatOfTheStandard) {
  // RFC 4648, section 10.
  EXPECT_EQ("", base64(""));
  EXPECT_EQ("Zg==", base64("f"));
  EXPECT_EQ("Zm8=", base64("fo"));
  EXPECT_EQ("Zm9v", base64("foo"));
  EXPECT_EQ("Zm9vYmFy", base64("foobar"));
  EXPECT_EQ("/////w==", base64("\xff\xff\xff\xff"));
}

TEST(ReportEncoding, ZigzagIsSmallWhereTheDifferenceIs) {
  EXPECT_EQ(0u, zigzag(0));
  EXPECT_EQ(1u, zigzag(-1));
  EXPECT_EQ(2u, zigzag(1));
  for (const std::int32_t v : {0, -1, 5, -32768, 32767, INT32_MIN, INT32_MAX}) EXPECT_EQ(v, unzigzag(zigzag(v)));
}

TEST(ReportEncoding, FramesComeBackAndSmoothOnesArePredicted) {
  Random random(1);
  std::vector<std::vector<std::uint16_t>> frames;
  for (int f = 0; f < 6; ++f) {
    std::vector<std::uint16_t>& frame = frames.emplace_back();
    // Linear motion that overflows, then a jump to random values.
    for (int i = 0; i < 500; ++i)
      frame.push_back(static_cast<std::uint16_t>(f < 5 ? 131 * i + f * (900 + i) : random.below(65536)));
  }
  std::string bytes;
  std::vector<int> orders;
  append_frames(bytes, frames, orders);
  EXPECT_EQ(frames, test::Planes(bytes).frames(orders, 500));
  EXPECT_EQ(0, orders[0]);
  EXPECT_EQ(2, orders[3]);
  EXPECT_EQ(bytes, test::inflated(deflated(bytes), bytes.size()));
}

}  // namespace
}  // namespace volccd
