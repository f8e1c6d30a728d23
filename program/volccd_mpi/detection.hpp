// The command `detect` of volccd-mpi.
#pragma once

#include <volccd/distributed/mpi/mpi_exchange.hpp>
#include <volccd/pipelines/registry.hpp>
#include <volccd/program/contact_query_options.hpp>
#include <volccd/program/report.hpp>

namespace volccd {

/// The contacts of the steps of a sequence, by all ranks. Files have the bytes that `volccd detect` writes; rank 0
/// prints the tables. Collective; throws a RankError.
void detect_on_ranks(distributed::MpiExchange& exchange, ContactQueryOptions options, const ReportOptions& report,
                     const Registry& registry);

}  // namespace volccd
