#include <volccd/io/output_file.hpp>

#include <atomic>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <optional>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <volccd/core/error.hpp>

namespace volccd {

namespace {

namespace fs = std::filesystem;

constexpr int kMaxLinks = 40;  ///< the limit of Linux

[[noreturn]] void fail_at(const std::string& name, const std::string& problem) {
  throw InputError(name, "", problem + ": " + std::strerror(errno));
}

/// The N of "/dev/fd/N" and similar names.
std::optional<int> descriptor_of(const std::string& name) {
  if (name == "-" || name == "/dev/stdout") return STDOUT_FILENO;
  if (name == "/dev/stderr") return STDERR_FILENO;
  for (const std::string& folder :
       {std::string("/dev/fd/"), std::string("/proc/self/fd/"), "/proc/" + std::to_string(::getpid()) + "/fd/"}) {
    if (!name.starts_with(folder)) continue;
    int number = -1;
    const char* const end = name.data() + name.size();
    const auto [stop, error] = std::from_chars(name.data() + folder.size(), end, number);
    if (error == std::errc{} && stop == end && number >= 0) return number;
  }
  return std::nullopt;
}

/// Forces the contents of a file, or the entries of a directory, to disk.
bool sync(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool done = ::fsync(descriptor) == 0;
  const int reason = errno;
  ::close(descriptor);
  errno = reason;
  return done;
}

[[noreturn]] void refuse_stream(const std::string& name, const char* reason) {
  throw InputError(name, "", std::string("is not a regular file: ") + reason + "; give the name of a file");
}

}  // namespace

OutputTarget output_target(const std::string& name) {
  if (name.empty()) throw InputError("\"\"", "", "cannot be written: the name is empty");
  std::string path = name;
  for (int links = 0; links <= kMaxLinks; ++links) {
    if (const auto descriptor = descriptor_of(path)) return {OutputTarget::Kind::descriptor, path, *descriptor};
    struct stat status {};
    if (::lstat(path.c_str(), &status) != 0) {
      if (errno != ENOENT) fail_at(name, "cannot be written");
      return {OutputTarget::Kind::file, path, -1};
    }
    if (S_ISREG(status.st_mode)) return {OutputTarget::Kind::file, path, -1};
    if (S_ISCHR(status.st_mode) || S_ISBLK(status.st_mode) || S_ISFIFO(status.st_mode))
      return {OutputTarget::Kind::device, path, -1};
    if (S_ISDIR(status.st_mode)) throw InputError(name, "", "cannot be written: it is a folder");
    if (!S_ISLNK(status.st_mode)) throw InputError(name, "", "cannot be written: it is a socket");
    std::error_code error;
    const fs::path link = fs::read_symlink(path, error);
    if (error) throw InputError(name, "", "cannot be written: " + error.message());
    path = (fs::path(path).parent_path() / link).string();
  }
  throw InputError(name, "", "cannot be written: too many symbolic links lead to one another");
}

bool is_standard_output(const std::string& name) {
  if (name.empty()) return false;
  const OutputTarget target = output_target(name);
  return target.kind == OutputTarget::Kind::descriptor && target.descriptor == STDOUT_FILENO;
}

OutputFile::OutputFile(std::string name, const char* only_files)
    : name_(std::move(name)), target_(output_target(name_)) {
  if (streams() && only_files) refuse_stream(name_, only_files);
  if (!streams()) {
    open_temporary();
    return;
  }
  std::fflush(stdout);
  descriptor_ = target_.kind == OutputTarget::Kind::descriptor
                    ? ::fcntl(target_.descriptor, F_DUPFD_CLOEXEC, 3)
                    : ::open(target_.path.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY);
  if (descriptor_ < 0) fail("cannot be opened for writing");
}

void OutputFile::open_temporary() {
  static std::atomic<unsigned> counter{0};
  struct stat old {};
  const bool there = ::stat(target_.path.c_str(), &old) == 0;
  if (there && ::access(target_.path.c_str(), W_OK) != 0) fail("cannot be written");
  for (;;) {
    const std::string name = target_.path + "." + std::to_string(::getpid()) + "-" + std::to_string(counter++) + ".tmp";
    descriptor_ = ::open(name.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666);
    if (descriptor_ >= 0) {
      temporary_ = name;
      break;
    }
    if (errno != EEXIST) fail("cannot be written");
  }
  // If the file system does not support such permissions, those of a new file are acceptable.
  if (there && ::fchmod(descriptor_, old.st_mode & 07777) != 0) errno = 0;
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : name_(std::move(other.name_)),
      temporary_(std::exchange(other.temporary_, {})),
      target_(std::move(other.target_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      size_(other.size_) {}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void OutputFile::fail(const std::string& problem) const { fail_at(name_, problem); }

void OutputFile::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail("cannot be written");
    size_ += written;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void OutputFile::truncate(std::int64_t size) {
  if (::ftruncate(descriptor_, size) != 0 || ::lseek(descriptor_, size, SEEK_SET) < 0) fail("cannot be cut");
  size_ = size;
}

void OutputFile::commit() {
  if (::close(std::exchange(descriptor_, -1)) != 0) fail("cannot be written");
  if (streams()) return;
  if (!sync(temporary_)) fail("cannot be brought to disk");
  if (std::rename(temporary_.c_str(), target_.path.c_str()) != 0) fail("cannot be renamed from its temporary name");
  temporary_.clear();
  // Syncs the rename itself. Some file systems cannot sync a directory; the file exists nevertheless.
  const fs::path folder = fs::path(target_.path).parent_path();
  sync(folder.empty() ? "." : folder.string());
}

void check_output(const std::string& name, const char* only_files) {
  if (output_target(name).kind == OutputTarget::Kind::file)
    const OutputFile file(name);
  else if (only_files)
    refuse_stream(name, only_files);
}

void write_text_file(const std::string& name, std::string_view text) {
  OutputFile file(name);
  file.write(text);
  file.commit();
}

}  // namespace volccd
