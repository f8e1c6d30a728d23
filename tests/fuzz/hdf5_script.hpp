// HDF5 files in memory for fuzzing: given images, or small valid files that a script of edits damages.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "targets.hpp"

namespace volccd::fuzz {

using Image = std::vector<std::uint8_t>;

/// A file that can be opened by its name while this object exists; it is in memory if the system has such a folder.
class MemoryFile {
 public:
  explicit MemoryFile(Bytes image);
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  const std::string& name() const { return name_; }
  Image image() const;

 private:
  int descriptor_;
  std::string name_;
};

/// The image of the file that `write` creates.
Image image_of(const std::function<void(const std::string& name)>& write);

/// Calls `read` with the name of a file. Bytes that begin like HDF5 are the image of the file. Otherwise the first byte
/// chooses a base file, and the others are at most 16 edits: they overwrite numbers with special values, remove
/// objects, declare them again with other shapes and types, change attributes, and flip bytes of the image. Edits that
/// HDF5 refuses are skipped. Remaining bytes are left to `read`. InputError is caught, because a reader is expected to
/// throw it.
void read_spoilt(Bytes bytes, const std::vector<Image>& bases,
                 const std::function<void(const std::string& name, std::uint8_t choice)>& read);

}  // namespace volccd::fuzz
