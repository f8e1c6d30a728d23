// Ranks as processes of MPI.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include <mpi.h>

#include <volccd/distributed/exchange.hpp>

namespace volccd::distributed {

/// The ranks of a communicator of MPI 3, with neighbourhood collectives. Messages are at most 2^31 - 1 bytes from one rank
/// to another; so is the sum of all bytes of an allgather. Operations throw Error for longer ones and for errors that
/// MPI reports. A rank that an exception leaves before the others have the same one must call MPI_Abort, otherwise the
/// others wait for it. Calls MPI from the calling thread alone: MPI_THREAD_FUNNELED suffices.
class MpiExchange final : public Exchange {
 public:
  /// Duplicates the communicator, so that messages of the caller and these do not meet. Collective. The exchange is
  /// destroyed by all ranks, before MPI_Finalize.
  explicit MpiExchange(MPI_Comm communicator);
  ~MpiExchange() override;
  MpiExchange(const MpiExchange&) = delete;
  MpiExchange& operator=(const MpiExchange&) = delete;

  int rank() const override { return rank_; }
  int size() const override { return size_; }
  std::unique_ptr<Neighbourhood> connect(std::vector<int> destinations) override;
  std::vector<Bytes> allgather(Bytes bytes) override;
  void allreduce(std::span<std::uint64_t> values, Reduction reduction) override;

  /// The duplicate, with MPI_ERRORS_RETURN.
  MPI_Comm communicator() const { return communicator_; }

 private:
  MPI_Comm communicator_ = MPI_COMM_NULL;
  int rank_ = 0, size_ = 1;
};

}  // namespace volccd::distributed
