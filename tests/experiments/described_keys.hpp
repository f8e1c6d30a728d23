// Whether docs/record.schema.json describes what an experiment writes.
#pragma once

#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace volccd::test {

/// `definition`: a name in $defs, such as "plus_summary".
inline void expect_described(const nlohmann::json& object, const std::string& definition) {
  std::ifstream file(VOLCCD_SOURCE_DIR "/docs/record.schema.json");
  const nlohmann::json keys = nlohmann::json::parse(file).at("$defs").at(definition).at("properties");
  for (const auto& [key, value] : object.items())
    EXPECT_TRUE(keys.contains(key)) << key << " is not in docs/record.schema.json";
}

}  // namespace volccd::test
