// A file that appears under its name only when it is complete.
#pragma once

#include <string>

namespace volccd::detail {

/// Makes an empty file beside `target`, under a temporary name that nobody else uses. commit() brings it to disk and
/// renames it to `target`, replacing what was there; without commit() the destructor removes it. Throws InputError
/// naming `target`, with the system's reason.
class AtomicFile {
 public:
  explicit AtomicFile(std::string target);
  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;
  ~AtomicFile();

  const std::string& target() const { return target_; }
  /// Where to write; empty after commit().
  const std::string& temporary() const { return temporary_; }

  /// Everything has been written and closed.
  void commit();

 private:
  std::string target_, temporary_;
};

}  // namespace volccd::detail
