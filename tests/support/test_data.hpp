// The folder of the shared sequences: $VOLCCD_DATA, or ../shared/data beside the project.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

namespace volccd::test {

/// Path of a file among the shared data, or an empty text if the file does not exist.
inline std::string shared_data(const std::string& name) {
  const char* given = std::getenv("VOLCCD_DATA");
  const std::filesystem::path folder = given ? given : VOLCCD_SOURCE_DIR "/../shared/data";
  const std::filesystem::path path = folder / name;
  return std::filesystem::exists(path) ? path.string() : std::string();
}

}  // namespace volccd::test

/// Skips the test with a message if the file does not exist.
#define VOLCCD_NEEDS_DATA(path, name)                         \
  const std::string path = ::volccd::test::shared_data(name); \
  if (path.empty()) GTEST_SKIP() << name << " is not there: put the shared data beside the project, or set VOLCCD_DATA"
