// The folder of a report: the page, and the scripts that hold its data.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace volccd {

/// A folder with index.html, volccd.css, volccd.js and data/. Opens from disk: the data are scripts too, because a
/// browser loads nothing else from there.
class ReportFolder {
 public:
  /// Finds the page: in the folder that VOLCCD_PAGE names, else in the prefix that contains the program or the Python
  /// module, else where it was built, else in the prefix that was configured. Throws ConfigError, which says how to
  /// build it, if it is in none of them; InputError for a folder that has files and is no report, and for one that
  /// cannot be made.
  explicit ReportFolder(std::string folder);

  /// Writes data/scene-NAME.js and returns this path.
  std::string write_scene(const std::string& name, const std::string& script);

  /// Writes the page and data/report.js, and removes scenes of an earlier report. Returns the bytes of all files.
  std::size_t finish(const nlohmann::json& report);

 private:
  void write_page_file(const char* name) const;

  std::string folder_, page_;
  std::vector<std::string> scenes_;
};

}  // namespace volccd
