// Files that a program writes: whole or not at all, and never in the place of a device, a FIFO or a link.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace volccd {

/// Where the bytes for a name given by the user go.
struct OutputTarget {
  enum class Kind {
    file,        ///< a regular file, or none yet: `path`, with all links at the end of the name followed
    device,      ///< a device or FIFO that exists: `path`
    descriptor,  ///< already open in this process: `descriptor`
  };
  Kind kind = Kind::file;
  std::string path;
  int descriptor = -1;
};

/// "-", /dev/stdout, /dev/stderr, /dev/fd/N and /proc/self/fd/N, also behind links, are descriptors. Throws InputError
/// naming `name` for a folder, a socket and links that lead in a circle.
OutputTarget output_target(const std::string& name);

/// Whether output to `name` goes to the standard output, so that nothing else may be printed there.
bool is_standard_output(const std::string& name);

/// An output. A regular file, or a name that does not exist yet, is written to an empty file beside it under a
/// temporary name, which commit() brings to disk and renames; the permissions of a file that is replaced are kept,
/// and one that may not be written is refused. A symbolic link stays, and its target is replaced. Without commit(), the
/// destructor removes the temporary file, and what was there before stays as it was. Devices, FIFOs and descriptors are
/// written to at once. Every error is an InputError that names the output and the system's reason. One thread at a
/// time.
class OutputFile {
 public:
  /// Opens. Blocks on a FIFO that nobody reads. `only_files`: why a device, FIFO or descriptor is refused; null: it is
  /// not.
  explicit OutputFile(std::string name, const char* only_files = nullptr);
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&&) = delete;
  ~OutputFile();

  /// As it was given.
  const std::string& name() const { return name_; }
  /// Devices, FIFOs and descriptors: what has been written cannot be taken back.
  bool streams() const { return target_.kind != OutputTarget::Kind::file; }
  /// The temporary file, for a library that opens files by name; empty where the output streams, and after commit().
  const std::string& temporary() const { return temporary_; }

  void write(std::string_view bytes);
  /// Bytes written.
  std::int64_t size() const { return size_; }
  /// Takes back what was written after the first `size` bytes. For files only.
  void truncate(std::int64_t size);

  /// All has been written.
  void commit();

 private:
  void open_temporary();
  [[noreturn]] void fail(const std::string& problem) const;

  std::string name_, temporary_;
  OutputTarget target_;
  int descriptor_ = -1;
  std::int64_t size_ = 0;
};

/// Throws what OutputFile(name, only_files) would, before long work; leaves nothing behind, and opens nothing that
/// streams.
void check_output(const std::string& name, const char* only_files = nullptr);

/// Writes a whole file, or streams the text to a device, FIFO or descriptor. Throws InputError.
void write_text_file(const std::string& name, std::string_view text);

}  // namespace volccd
