#include <volccd/program/output_plan.hpp>

#include <filesystem>

#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/io/output_file.hpp>

namespace volccd {

OutputPlan::Place OutputPlan::place_of(const std::string& option, const std::string& file) {
  Place place;
  place.option = option;
  place.name = file;
  std::error_code ignored;
  place.path = std::filesystem::weakly_canonical(std::filesystem::absolute(file, ignored), ignored).string();
  return place;
}

void OutputPlan::input(const std::string& option, const std::string& file) {
  if (file.empty()) return;
  Place place = place_of(option, file);
  struct stat status {};
  place.exists = ::stat(file.c_str(), &status) == 0;
  place.device = status.st_dev, place.inode = status.st_ino;
  inputs_.push_back(std::move(place));
}

void OutputPlan::output(const std::string& option, const std::string& file, const char* only_files) {
  if (file.empty()) return;
  const OutputTarget target = output_target(file);
  Place place = place_of(option, target.path);
  place.name = file;
  place.only_files = only_files;
  place.descriptor = target.descriptor;
  struct stat status {};
  place.exists =
      (target.descriptor >= 0 ? ::fstat(target.descriptor, &status) : ::stat(target.path.c_str(), &status)) == 0;
  place.device = status.st_dev, place.inode = status.st_ino;
  place.shared = place.exists && S_ISCHR(status.st_mode);
  outputs_.push_back(std::move(place));
}

bool OutputPlan::same(const Place& a, const Place& b) {
  if (a.descriptor >= 0 && a.descriptor == b.descriptor) return true;
  if (a.shared || b.shared) return false;
  if (a.exists || b.exists) return a.exists && b.exists && a.device == b.device && a.inode == b.inode;
  return a.descriptor < 0 && b.descriptor < 0 && a.path == b.path;
}

void OutputPlan::check() const {
  const auto refuse = [](const Place& output, const Place& other) {
    throw ConfigError(
        fmt::format("{} ({}) and {} ({}) are the same file: nothing has been written; give {} another name",
                    other.option, other.name, output.option, output.name, output.option));
  };
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    for (const Place& input : inputs_)
      if (same(outputs_[i], input)) refuse(outputs_[i], input);
    for (std::size_t j = 0; j < i; ++j)
      if (same(outputs_[i], outputs_[j])) refuse(outputs_[i], outputs_[j]);
  }
  for (const Place& output : outputs_) check_output(output.name, output.only_files);
  struct stat status {};
  if (report() != stdout || ::fstat(STDOUT_FILENO, &status) != 0 || !S_ISREG(status.st_mode)) return;
  Place screen;
  screen.option = "standard output";
  screen.name = "the report";
  screen.exists = true;
  screen.device = status.st_dev, screen.inode = status.st_ino;
  for (const Place& output : outputs_)
    if (same(output, screen)) refuse(output, screen);
}

std::FILE* OutputPlan::report() const {
  for (const Place& output : outputs_)
    if (output.descriptor == STDOUT_FILENO) return stderr;
  return stdout;
}

}  // namespace volccd
