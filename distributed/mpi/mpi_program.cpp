#include <volccd/distributed/mpi/mpi_program.hpp>

#include <cstdio>
#include <exception>
#include <optional>

#include <fmt/format.h>

#include <volccd/distributed/agreement.hpp>

namespace volccd::distributed {

namespace {

constexpr int kFailed = 2;

int run_or_abort(const char* name, FunctionRef<int(MpiExchange&)> body) {
  int rank = 0, size = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  std::optional<MpiExchange> exchange;  // outlives the messages below: to destroy it is collective
  try {
    exchange.emplace(MPI_COMM_WORLD);
    try {
      return body(*exchange);
    } catch (const RankError& error) {
      if (rank == 0) fmt::print(stderr, "{}: {}\n", name, error.what());
      return kFailed;
    }
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: rank {} of {}: {}\n", name, rank, size, problem_of(error));
  } catch (...) {
    fmt::print(stderr, "{}: rank {} of {}: unknown exception\n", name, rank, size);
  }
  std::fflush(nullptr);
  MPI_Abort(MPI_COMM_WORLD, kFailed);
  return kFailed;
}

}  // namespace

int run_mpi_program(const char* name, int argc, char** argv, FunctionRef<int(MpiExchange&)> body) {
  int provided = MPI_THREAD_SINGLE;
  if (MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided) != MPI_SUCCESS) {
    fmt::print(stderr, "{}: MPI cannot be initialised\n", name);
    return kFailed;
  }
  const int code = run_or_abort(name, body);
  MPI_Finalize();
  return code;
}

}  // namespace volccd::distributed
