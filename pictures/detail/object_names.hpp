// The objects of several sequences, and their names in the options of a picture.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace volccd::detail {

class ObjectNames {
 public:
  /// Adds objects, and those that have a name. The first name of an object stays.
  void add(const std::set<std::int32_t>& objects, const std::map<std::int32_t, std::string>& names);

  const std::set<std::int32_t>& objects() const { return objects_; }
  /// "object 3" if it has none.
  std::string name_of(std::int32_t object) const;

  /// The objects of a list of ids and names (case-insensitive), separated by commas, or by semicolons if there is one;
  /// a name may also be the whole text. Throws ConfigError, which begins with `option`, for one that is unknown.
  std::set<std::int32_t> parse(const std::string& option, const std::string& text) const;

 private:
  std::vector<std::string> names() const;
  std::string known() const;

  std::set<std::int32_t> objects_;
  std::map<std::int32_t, std::string> names_;
};

}  // namespace volccd::detail
