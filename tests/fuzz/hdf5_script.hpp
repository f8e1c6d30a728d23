// HDF5 files in memory for fuzzing: images as they are, or small valid files that a script of edits spoils.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "targets.hpp"

namespace volccd::fuzz {

using Image = std::vector<std::uint8_t>;

/// A file that can be opened by name while it lives; in memory where the system has such a folder.
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

/// The image of the file that `write` makes.
Image image_of(const std::function<void(const std::string& name)>& write);

/// Calls `read` with the name of a file. Bytes that begin like HDF5 are its image. Else the first chooses a base, and
/// the rest are edits, at most 16: numbers overwritten with telling values, objects removed, declared anew with other
/// shapes and types, attributes changed, bytes of the image flipped. Edits that HDF5 refuses are left out. What is not
/// taken by the script, if anything, is up to `read`. InputError is caught: it is what a reader has to throw.
void read_spoilt(Bytes bytes, const std::vector<Image>& bases,
                 const std::function<void(const std::string& name, std::uint8_t choice)>& read);

}  // namespace volccd::fuzz
