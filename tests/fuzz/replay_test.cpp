// Replays every committed input with the compiler and the sanitizers of the tests. Inputs that once broke a promise are
// kept in the corpus.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include <gtest/gtest.h>

#include "targets.hpp"

namespace volccd::fuzz {
namespace {

void replay(const char* target, void (*run)(Bytes)) {
  const std::filesystem::path folder = std::filesystem::path(VOLCCD_SOURCE_DIR) / "tests/fuzz/corpus" / target;
  std::vector<std::filesystem::path> files(std::filesystem::directory_iterator(folder), {});
  std::sort(files.begin(), files.end());
  ASSERT_FALSE(files.empty());
  for (const std::filesystem::path& path : files) {
    SCOPED_TRACE(path.string());
    std::ifstream in(path, std::ios::binary);
    const std::vector<char> bytes((std::istreambuf_iterator<char>(in)), {});
    EXPECT_NO_THROW(run({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}));
  }
}

TEST(FuzzCorpus, SequenceReader) { replay("sequence_reader", sequence_reader); }
TEST(FuzzCorpus, QueryReader) { replay("query_reader", query_reader); }
TEST(FuzzCorpus, OptionParser) { replay("option_parser", option_parser); }
TEST(FuzzCorpus, NarrowPhase) { replay("narrow_phase", narrow_phase); }
TEST(FuzzCorpus, Pipeline) { replay("pipeline", pipeline); }

}  // namespace
}  // namespace volccd::fuzz
