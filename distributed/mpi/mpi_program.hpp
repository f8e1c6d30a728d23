// A program whose processes are ranks.
#pragma once

#include <volccd/core/function_ref.hpp>
#include <volccd/distributed/mpi/mpi_exchange.hpp>

namespace volccd::distributed {

/// Runs body(exchange) on all processes of MPI_COMM_WORLD, between MPI_Init_thread and MPI_Finalize, and returns its
/// result, the exit code of this process. If it throws a RankError, which all ranks throw, rank 0 prints "`name`: text"
/// on stderr, and the exit code is 2. If another exception leaves a rank, the rank prints its number and the text, and
/// ends all processes by MPI_Abort, so that the others do not wait for it.
int run_mpi_program(const char* name, int argc, char** argv, FunctionRef<int(MpiExchange& exchange)> body);

}  // namespace volccd::distributed
