#include <volccd/report/page_files.hpp>

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/io/output_file.hpp>

namespace volccd {

namespace {

namespace fs = std::filesystem;

constexpr const char* kPageFiles[] = {"volccd.js", "volccd.css", "index.html"};  ///< the marker first
constexpr const char* kMarker = "volccd.js";               ///< a folder with this file is a report
constexpr const char* kUnfinished = ".volccd-unfinished";  ///< a folder with this subfolder was to become a report

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

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      default: out += c;
    }
  return out;
}

std::string link(const std::string& place, const std::string& text) {
  return fmt::format("<a href=\"#{}\">{}</a>", escaped(place), escaped(text));
}

void replace_mark(std::string& page, std::string_view mark, const std::string& text) {
  if (const std::size_t at = page.find(mark); at != std::string::npos) page.replace(at, mark.size(), text);
}

/// index.html with the names of parts, records and scenes.
std::string index_page(std::string page, const nlohmann::json& report) {
  std::string parts, contents;
  const nlohmann::json &records = report.at("records"), &scenes = report.at("scenes");
  if (!records.empty()) parts = link("overview", "Overview") + link("tables", "Tables") + link("figures", "Figures");
  if (!scenes.empty()) parts += link("scenes", records.empty() ? "Scene" : "Scenes");
  for (const nlohmann::json& record : records) {
    const std::string name = record.at("name");
    contents += fmt::format("<li>{}: {}.</li>\n", link("tables/" + name, name),
                            escaped(record.at("description").get<std::string>()));
  }
  for (const nlohmann::json& scene : scenes)
    if (!scene.contains("missing")) {
      const std::string name = scene.at("name");
      contents += fmt::format("<li>{}</li>\n", link("scenes/" + name, name));
    }
  replace_mark(page, "<!-- parts -->", parts);
  replace_mark(page, "<!-- contents -->", "<ul>\n" + contents + "</ul>");
  return page;
}

}  // namespace

ReportFolder::ReportFolder(std::string folder) : folder_(std::move(folder)), page_(find_page()) {
  const fs::path path = folder_;
  std::error_code error;
  made_ = !fs::exists(path, error);
  const bool empty = made_ || (fs::is_directory(path, error) && fs::is_empty(path, error));
  if (!empty && !fs::is_regular_file(path / kMarker, error) && !fs::is_directory(path / kUnfinished, error))
    throw InputError(folder_, "", "has files and is no report of volccd: choose a new folder with -o");
  if (!made_ && fs::equivalent(path, page_, error))
    throw InputError(folder_, "",
                     "has the page from which all reports are made, and the report would overwrite it: choose a new "
                     "folder with -o");
  fs::remove_all(path / kUnfinished, error);
  if (!error) fs::create_directories(path / kUnfinished / "data", error);
  if (error) throw InputError(folder_, "", "is the folder of the report and cannot be made: " + error.message());
}

ReportFolder::~ReportFolder() {
  std::error_code ignored;
  fs::remove_all(fs::path(folder_) / kUnfinished, ignored);
  if (made_) fs::remove(folder_, ignored);  // only if it is empty
}

void ReportFolder::write(const std::string& path, std::string_view text) const {
  write_text_file((fs::path(folder_) / kUnfinished / path).string(), text);
}

std::string ReportFolder::write_scene(const std::string& name, const std::string& script) {
  const std::string path = "data/scene-" + name + ".js";
  write(path, script);
  scenes_.push_back(path);
  return path;
}

std::string ReportFolder::copy_picture(const std::string& scene, const std::string& file) {
  const std::string path = "data/scene-" + scene + ".png";
  if (std::find(scenes_.begin(), scenes_.end(), path) != scenes_.end()) return path;
  write(path, contents(file));
  scenes_.push_back(path);
  return path;
}

void ReportFolder::replace(const std::string& path) const {
  std::error_code error;
  const fs::path to = fs::path(folder_) / path;
  fs::create_directories(to.parent_path(), error);
  fs::rename(fs::path(folder_) / kUnfinished / path, to, error);
  if (error) throw InputError(to.string(), "", "cannot be replaced: " + error.message());
}

void ReportFolder::remove_old_scenes() const {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(fs::path(folder_) / "data", error)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("scene-") && (name.ends_with(".js") || name.ends_with(".png")) &&
        std::find(scenes_.begin(), scenes_.end(), "data/" + name) == scenes_.end())
      fs::remove(entry.path(), error);
  }
}

std::size_t ReportFolder::finish(const nlohmann::json& report) {
  const std::string text = report.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  write("data/report.js", "volccd_report = " + text + ";\n");
  for (const char* name : kPageFiles) {
    const std::string page_file = contents(fs::path(page_) / name);
    write(name, name == std::string_view("index.html") ? index_page(page_file, report) : page_file);
  }
  // A process that is killed while it moves the files leaves a folder without data/report.js, and the page says that
  // it is missing. Otherwise old data could stand beside new scenes.
  const fs::path old_data = fs::path(folder_) / "data/report.js";
  std::error_code error;
  fs::remove(old_data, error);
  if (error) throw InputError(old_data.string(), "", "of the earlier report cannot be removed: " + error.message());
  for (const char* name : kPageFiles) replace(name);
  for (const std::string& scene : scenes_) replace(scene);
  remove_old_scenes();
  replace("data/report.js");
  fs::remove_all(fs::path(folder_) / kUnfinished, error);
  std::size_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder_))
    if (entry.is_regular_file()) bytes += entry.file_size();
  return bytes;
}

}  // namespace volccd
