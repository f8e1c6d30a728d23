// Ranks as processes of MPI.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include <mpi.h>

#include <volccd/distributed/exchange.hpp>

namespace volccd::distributed {

/// The ranks of a communicator of MPI 3. Messages of a neighbourhood go from process to process; a rank learns who sends
/// to it by a barrier that does not block (Hoefler, Siebert, Lumsdaine, 2010), so that no operation but allgather() takes
/// time proportional to the number of ranks. A message has at most 2^31 - 1 bytes; so has the sum of all in an
/// allgather. Operations throw Error for longer ones and for errors that MPI reports. A rank that an exception leaves
/// before the others have the same one must call MPI_Abort, otherwise the others wait for it. Calls MPI from the calling
/// thread alone: MPI_THREAD_FUNNELED suffices.
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
  int connections_ = 0;  ///< modulo 2: a rank may begin the next connect() while another has not left the last one
};

}  // namespace volccd::distributed
