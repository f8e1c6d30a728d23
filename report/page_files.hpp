// The folder of a report: the page, and the scripts that hold its data.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace volccd {

/// A folder with index.html, volccd.css, volccd.js and data/. It opens from disk: the data are scripts too, because a
/// browser loads nothing else from there. index.html has the names of the parts, records and scenes, which a browser
/// shows before it has read the data.
///
/// All files are written to the subfolder `.volccd-unfinished` first, and finish() moves them to their places. Without
/// finish(), the destructor removes the subfolder, and an earlier report in the folder is unchanged. If the process is
/// killed, the subfolder remains; the next report removes it. While finish() moves files, the folder has no
/// data/report.js; a page that is opened then says that it is missing.
class ReportFolder {
 public:
  /// Finds the page: in the folder that VOLCCD_PAGE names, else in the prefix that contains the program or the Python
  /// module, else where it was built, else in the prefix that was configured. Throws ConfigError, which says how to
  /// build it, if it is in none of them; InputError for a folder that has files and is no report, for the folder of
  /// the page itself, and for one that cannot be made.
  explicit ReportFolder(std::string folder);
  ReportFolder(const ReportFolder&) = delete;
  ReportFolder& operator=(const ReportFolder&) = delete;
  ~ReportFolder();

  /// Writes the script of a scene. Returns its path in the finished report, data/scene-NAME.js.
  std::string write_scene(const std::string& name, const std::string& script);

  /// Copies the picture of a scene, a PNG file. Returns its path in the finished report, data/scene-SCENE.png. A scene
  /// of which there are several sequences has one picture. Throws InputError.
  std::string copy_picture(const std::string& scene, const std::string& file);

  /// Writes the page and data/report.js, moves all files to their places, and removes the scenes of an earlier report.
  /// Returns the bytes of the files in the folder. Throws InputError; if data/report.js of the earlier report cannot be
  /// removed, this report is unchanged.
  std::size_t finish(const nlohmann::json& report);

 private:
  void write(const std::string& path, std::string_view text) const;
  void replace(const std::string& path) const;
  void remove_old_scenes() const;

  std::string folder_, page_;
  bool made_ = false;                ///< the folder did not exist
  std::vector<std::string> scenes_;  ///< paths of scripts and pictures
};

}  // namespace volccd
