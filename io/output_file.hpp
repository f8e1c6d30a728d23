// Output files of programs. A file is written completely or not at all, and never replaces a device, a FIFO or a link.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace volccd {

/// The kind of the output for a file name that the user gave.
struct OutputTarget {
  enum class Kind {
    file,        ///< a regular file, or no file yet: `path` is the name after all symbolic links are followed
    device,      ///< an existing device or FIFO: `path` is its name
    descriptor,  ///< a descriptor that is already open in this process: `descriptor`
  };
  Kind kind = Kind::file;
  std::string path;
  int descriptor = -1;
};

/// "-", /dev/stdout, /dev/stderr, /dev/fd/N and /proc/self/fd/N, and symbolic links to them, are descriptors. Throws
/// InputError that names `name` for a directory, a socket, or a cycle of links.
OutputTarget output_target(const std::string& name);

/// Whether output to `name` goes to the standard output, so that nothing else may be printed there.
bool is_standard_output(const std::string& name);

/// An output. If the name is that of a regular file, or does not exist yet, the bytes go to a temporary file in the
/// same directory; commit() writes them to disk and renames the file. The permissions of a replaced file are kept; a
/// file without write permission is refused. A symbolic link is kept, and its target is replaced. Without commit(), the
/// destructor removes the temporary file and the previous file is unchanged. Devices, FIFOs and descriptors are written
/// to immediately. Every error is an InputError that names the output and the reason that the system gives. Not
/// thread-safe.
class OutputFile {
 public:
  /// Opens the output; blocks on a FIFO that has no reader. If `only_files` is not null, devices, FIFOs and descriptors
  /// are refused, and `only_files` is the reason in the message.
  explicit OutputFile(std::string name, const char* only_files = nullptr);
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&&) = delete;
  ~OutputFile();

  /// The name as the caller gave it.
  const std::string& name() const { return name_; }
  /// True for devices, FIFOs and descriptors: bytes once written cannot be removed.
  bool streams() const { return target_.kind != OutputTarget::Kind::file; }
  /// Name of the temporary file, for a library that opens files by name. Empty for devices, FIFOs and descriptors, and
  /// after commit().
  const std::string& temporary() const { return temporary_; }

  void write(std::string_view bytes);
  /// Number of bytes written.
  std::int64_t size() const { return size_; }
  /// Removes all bytes after the first `size` bytes. Only for regular files.
  void truncate(std::int64_t size);

  /// Completes the output. Must follow the last write().
  void commit();

 private:
  void open_temporary();
  [[noreturn]] void fail(const std::string& problem) const;

  std::string name_, temporary_;
  OutputTarget target_;
  int descriptor_ = -1;
  std::int64_t size_ = 0;
};

/// Throws the errors that OutputFile(name, only_files) would throw, so that they are found before a long computation.
/// Leaves no file behind, and does not open devices, FIFOs or descriptors.
void check_output(const std::string& name, const char* only_files = nullptr);

/// Writes a whole file, or writes the text to a device, FIFO or descriptor. Throws InputError.
void write_text_file(const std::string& name, std::string_view text);

}  // namespace volccd
