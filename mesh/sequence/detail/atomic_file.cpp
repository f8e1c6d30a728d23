#include <volccd/mesh/sequence/detail/atomic_file.hpp>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include <volccd/core/error.hpp>

namespace volccd::detail {

namespace {

[[noreturn]] void fail(const std::string& target, const std::string& what) {
  throw InputError(target, "", what + ": " + std::strerror(errno));
}

/// Forces a file, or the entries of a folder, to disk.
bool sync(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool done = ::fsync(descriptor) == 0;
  const int reason = errno;
  ::close(descriptor);
  errno = reason;
  return done;
}

}  // namespace

AtomicFile::AtomicFile(std::string target) : target_(std::move(target)) {
  static std::atomic<unsigned> counter{0};
  std::error_code ignored;
  if (std::filesystem::is_directory(target_, ignored))
    throw InputError(target_, "", "cannot be written: it is a folder");
  for (;;) {
    const std::string name = target_ + "." + std::to_string(::getpid()) + "-" + std::to_string(counter++) + ".tmp";
    const int descriptor = ::open(name.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666);
    if (descriptor >= 0) {
      ::close(descriptor);
      temporary_ = name;
      return;
    }
    if (errno != EEXIST) fail(target_, "cannot be written");
  }
}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : target_(std::move(other.target_)), temporary_(std::exchange(other.temporary_, {})) {}

AtomicFile::~AtomicFile() {
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void AtomicFile::commit() {
  if (!sync(temporary_)) fail(target_, "cannot be brought to disk");
  if (std::rename(temporary_.c_str(), target_.c_str()) != 0) fail(target_, "cannot be renamed from its temporary name");
  temporary_.clear();
  // The rename itself; some file systems cannot sync a folder, and then the file is there all the same.
  const std::filesystem::path folder = std::filesystem::path(target_).parent_path();
  sync(folder.empty() ? "." : folder.string());
}

}  // namespace volccd::detail
