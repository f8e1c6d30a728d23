#include <volccd/experiments/scenes/shared_data.hpp>

#include <cstdlib>
#include <filesystem>

namespace volccd {

std::string shared_data_path(const std::string& name) {
  const char* given = std::getenv("VOLCCD_DATA");
  return (std::filesystem::path(given ? given : VOLCCD_DEFAULT_DATA) / name).lexically_normal().string();
}

}  // namespace volccd
