// The inputs and outputs of one run: no output may overwrite an input or another output.
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

namespace volccd {

/// All inputs and outputs are added, then check() is called, before anything is written. Files are identified by device
/// and inode, and files that do not exist yet by their path without links. The standard output may be used once,
/// /dev/null repeatedly. `only_files`: as for OutputFile.
class OutputPlan {
 public:
  /// `option`: the name in messages, such as "--contacts" or "FILE". An empty `file` is ignored. Throws InputError for
  /// an output that is a folder or a socket.
  void input(const std::string& option, const std::string& file);
  void output(const std::string& option, const std::string& file, const char* only_files = nullptr);

  /// Throws ConfigError, which names both options, if an output is an input, another output, or the regular file that
  /// the standard output goes to; InputError if one cannot be written.
  void check() const;

  /// The stream for text: stderr if an output goes to the standard output.
  std::FILE* report() const;

 private:
  struct Place {
    std::string option, name, path;
    const char* only_files = nullptr;
    int descriptor = -1;  ///< an open one of this process, or -1
    bool exists = false, shared = false;
    std::uint64_t device = 0, inode = 0;
  };
  static Place place_of(const std::string& option, const std::string& file);
  static bool same(const Place& a, const Place& b);

  std::vector<Place> inputs_, outputs_;
};

}  // namespace volccd
