// A text file that all ranks write together.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <mpi.h>

#include <volccd/distributed/mpi/mpi_exchange.hpp>
#include <volccd/io/output_file.hpp>

namespace volccd {

/// Regular files only, by the rules of OutputFile on rank 0: the file appears under its name when it is finished, and
/// not at all otherwise. All ranks write to the same file system. All members but the destructor are collective and
/// throw a RankError.
class SharedTextFile {
 public:
  SharedTextFile(distributed::MpiExchange& exchange, std::string name);
  /// Removes the file if it is not finished. Calls nothing collective, so that an exception that leaves one rank alone
  /// does not wait for the others here.
  ~SharedTextFile() = default;
  SharedTextFile(const SharedTextFile&) = delete;
  SharedTextFile& operator=(const SharedTextFile&) = delete;

  const std::string& name() const { return name_; }

  /// Appends the texts of all ranks, in the order of the ranks.
  void write(std::string_view text);
  void finish();
  /// Closes the file, which the destructor then removes. To be called after a RankError.
  void discard();

 private:
  void check(int code, const char* operation) const;

  distributed::MpiExchange& exchange_;
  std::string name_;
  std::optional<OutputFile> output_;  ///< on rank 0
  MPI_File file_ = MPI_FILE_NULL;
  std::uint64_t size_ = 0;
};

}  // namespace volccd
