#include <volccd/program/volccd_mpi/shared_text_file.hpp>

#include <algorithm>
#include <utility>

#include <volccd/core/error.hpp>
#include <volccd/distributed/agreement.hpp>

namespace volccd {

namespace {
/// Bytes that a rank writes in one operation, which counts them in an int.
constexpr std::uint64_t kBytesAtOnce = std::uint64_t{1} << 30;
}  // namespace

SharedTextFile::SharedTextFile(distributed::MpiExchange& exchange, std::string name)
    : exchange_(exchange), name_(std::move(name)) {
  using distributed::run_on_all;
  run_on_all(exchange, "output", [&] {
    if (exchange.rank() == 0) output_.emplace(name_, "all processes write to it");
  });
  const std::string mine = output_ ? output_->temporary() : std::string();
  const std::string temporary = distributed::text_of(exchange.allgather(distributed::to_bytes(mine)).front());
  const int code = MPI_File_open(exchange.communicator(), temporary.c_str(), MPI_MODE_WRONLY, MPI_INFO_NULL, &file_);
  run_on_all(exchange, "output", [&] { check(code, "cannot be opened"); });
}

void SharedTextFile::discard() {
  if (file_ != MPI_FILE_NULL) MPI_File_close(&file_);
}

void SharedTextFile::check(int code, const char* problem) const {
  if (code == MPI_SUCCESS) return;
  char text[MPI_MAX_ERROR_STRING];
  int length = 0;
  if (MPI_Error_string(code, text, &length) != MPI_SUCCESS) length = 0;
  throw InputError(name_, "", problem + (": " + std::string(text, static_cast<std::size_t>(length))));
}

void SharedTextFile::write(std::string_view text) {
  std::uint64_t begin = size_, rounds = 0;
  const distributed::Bytes mine = distributed::to_bytes(std::to_string(text.size()));
  const std::vector<distributed::Bytes> sizes = exchange_.allgather(mine);
  for (int r = 0; r < exchange_.size(); ++r) {
    const std::uint64_t size = std::stoull(distributed::text_of(sizes[static_cast<std::size_t>(r)]));
    if (r < exchange_.rank()) begin += size;
    size_ += size;
    rounds = std::max(rounds, (size + kBytesAtOnce - 1) / kBytesAtOnce);
  }
  for (; rounds > 0; --rounds) {
    const std::string_view part = text.substr(0, kBytesAtOnce);
    MPI_Status status;
    const int code = MPI_File_write_at_all(file_, static_cast<MPI_Offset>(begin), part.data(),
                                           static_cast<int>(part.size()), MPI_BYTE, &status);
    distributed::run_on_all(exchange_, "output", [&] {
      check(code, "cannot be written");
      int written = 0;
      MPI_Get_count(&status, MPI_BYTE, &written);
      if (!part.empty() && written != static_cast<int>(part.size()))
        throw InputError(name_, "", "cannot be written completely: is the disk full?");
    });
    begin += part.size();
    text.remove_prefix(part.size());
  }
}

void SharedTextFile::finish() {
  const int synced = MPI_File_sync(file_);
  const int closed = MPI_File_close(&file_);
  distributed::run_on_all(exchange_, "output", [&] {
    check(synced, "cannot be brought to disk");
    check(closed, "cannot be closed");
  });
  distributed::run_on_all(exchange_, "output", [&] {
    if (output_) output_->commit();
  });
}

}  // namespace volccd
