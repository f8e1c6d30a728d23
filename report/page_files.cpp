#include <volccd/report/page_files.hpp>

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/core/output_file.hpp>

namespace volccd {

namespace {

namespace fs = std::filesystem;

constexpr const char* kMarker = "volccd.js";  ///< a folder with this file is a report
constexpr const char* kPageFiles[] = {"index.html", "volccd.css", kMarker};

bool has_page(const fs::path& folder) {
  return std::all_of(std::begin(kPageFiles), std::end(kPageFiles),
                     [&](const char* name) { return fs::is_regular_file(folder / name); });
}

/// The page in the prefix that contains this code, wherever the prefix was moved or unpacked to; empty if there is
/// none. This code is in the program (PREFIX/bin) or in the Python module (below PREFIX/lib).
std::string page_of_this_prefix() {
  std::error_code error;
  fs::path place = fs::read_symlink("/proc/self/exe", error);
  Dl_info info;
  // A library's name is a path; the program's is what it was called by.
  if (dladdr(kPageFiles, &info) && fs::path(info.dli_fname).extension() == ".so") place = fs::absolute(info.dli_fname);
  for (int levels = 0; levels < 6 && place.has_relative_path(); ++levels) {
    place = place.parent_path();
    if (has_page(place / VOLCCD_PAGE_IN_PREFIX)) return place / VOLCCD_PAGE_IN_PREFIX;
  }
  return {};
}

std::string find_page() {
  if (const char* given = std::getenv("VOLCCD_PAGE")) {
    if (has_page(given)) return given;
    throw ConfigError(
        fmt::format("VOLCCD_PAGE: {} has no index.html, volccd.css and volccd.js; scripts/build-report -o "
                    "FOLDER writes them",
                    given));
  }
  if (std::string found = page_of_this_prefix(); !found.empty()) return found;
  for (const char* folder : {VOLCCD_PAGE_BUILD, VOLCCD_PAGE_INSTALLED})
    if (has_page(folder)) return folder;
  throw ConfigError(fmt::format(
      "the page of the report is not built: neither {} nor {} has it. Run `apt install esbuild libjs-three`, then "
      "`scripts/build-report -o FOLDER` in the sources, and set VOLCCD_PAGE to FOLDER; or configure and build again",
      VOLCCD_PAGE_BUILD, VOLCCD_PAGE_INSTALLED));
}

std::string contents(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in) throw InputError(file.string(), "", "cannot be read");
  return text;
}

}  // namespace

ReportFolder::ReportFolder(std::string folder) : folder_(std::move(folder)), page_(find_page()) {
  std::error_code error;
  const bool empty = !fs::exists(folder_, error) || (fs::is_directory(folder_, error) && fs::is_empty(folder_, error));
  if (!empty && !fs::is_regular_file(fs::path(folder_) / kMarker, error))
    throw InputError(folder_, "", "has files and is no report of volccd: choose a new folder with -o");
  fs::create_directories(fs::path(folder_) / "data", error);
  if (error) throw InputError(folder_, "", "is the folder of the report and cannot be made: " + error.message());
  // From now on it is a report, so that the same command can go on after Ctrl-C.
  write_page_file(kMarker);
}

void ReportFolder::write_page_file(const char* name) const {
  write_text_file((fs::path(folder_) / name).string(), contents(fs::path(page_) / name));
}

std::string ReportFolder::write_scene(const std::string& name, const std::string& script) {
  const std::string path = "data/scene-" + name + ".js";
  write_text_file((fs::path(folder_) / path).string(), script);
  scenes_.push_back(path);
  return path;
}

std::size_t ReportFolder::finish(const nlohmann::json& report) {
  for (const auto& entry : fs::directory_iterator(fs::path(folder_) / "data")) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("scene-") && name.ends_with(".js") &&
        std::find(scenes_.begin(), scenes_.end(), "data/" + name) == scenes_.end())
      fs::remove(entry.path());
  }
  for (const char* name : kPageFiles) write_page_file(name);
  const std::string text = report.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  write_text_file((fs::path(folder_) / "data/report.js").string(), "volccd_report = " + text + ";\n");
  std::size_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder_))
    if (entry.is_regular_file()) bytes += entry.file_size();
  return bytes;
}

}  // namespace volccd
