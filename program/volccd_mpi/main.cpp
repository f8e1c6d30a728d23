// volccd-mpi: the command `detect` of `volccd` by several processes.

#include <csignal>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <volccd/distributed/agreement.hpp>
#include <volccd/distributed/mpi/mpi_program.hpp>
#include <volccd/io/build_facts.hpp>
#include <volccd/io/hdf5/hdf5_messages.hpp>
#include <volccd/paper2011/paper2011.hpp>
#include <volccd/peers/peers.hpp>
#include <volccd/program/command_line.hpp>
#include <volccd/program/commands.hpp>
#include <volccd/program/progress.hpp>
#include <volccd/program/shell_documents.hpp>
#include <volccd/program/volccd_mpi/detection.hpp>

namespace volccd {

namespace {

struct Options : ContactQueryOptions {
  ReportOptions report;
};

void add_detect(CLI::App& app, Options& options) {
  CLI::App* command = app.add_subcommand("detect", "contacts of the steps in a sequence");
  options.query.threads = 1;
  options.add_to(*command);
  options.report.add_quiet_to(*command);
  command->footer(
      "Outputs are regular files with the bytes that `volccd detect` writes; they appear when all steps are done. "
      "--threads: of each process.\n"
      "Examples:\n"
      "  mpirun -n 4 volccd-mpi detect run.vtkhdf --contacts contacts.csv\n"
      "  mpirun -n 4 volccd-mpi detect run.vtkhdf --steps 4:8 --separation 0.01 --first\n"
      "  mpirun -n 4 volccd-mpi detect run.vtkhdf --substeps 100 --separation 0.01 --contacts contacts.csv");
}

/// What a rank prints after its command line is parsed, if it has nothing to run.
struct Stop {
  int code = kDone;
  std::string out, err;
};

std::optional<Stop> parse(CLI::App& app, int argc, char** argv) {
  if (argc == 2 && std::string_view(argv[1]) == "--manual-page")
    return Stop{kDone, manual_page(app, build_facts().version), ""};
  try {
    check_command_names(app, argc, argv);
    app.parse(argc, argv);
    return std::nullopt;
  } catch (const CLI::ExtrasError&) {
    return Stop{kBadInput, "", fmt::format("volccd-mpi: {}\n", unexpected_arguments(app))};
  } catch (const CLI::ParseError& error) {
    std::ostringstream out, err;
    const int code = app.exit(error, out, err);
    return Stop{code == 0 ? kDone : kBadInput, out.str(), err.str()};
  } catch (const ConfigError& error) {
    return Stop{kBadInput, "", fmt::format("volccd-mpi: {}\n", error.what())};
  }
}

/// Whether a rank stops; then the lowest of these prints, and `code` is the greatest.
bool any_stops(distributed::MpiExchange& exchange, const std::optional<Stop>& stop, int& code) {
  std::uint64_t values[] = {stop ? 1u : 0u, stop ? static_cast<std::uint64_t>(stop->code) : 0u};
  auto lowest = static_cast<std::uint64_t>(stop ? exchange.rank() : exchange.size());
  exchange.allreduce(values, distributed::Reduction::max);
  exchange.allreduce({&lowest, 1}, distributed::Reduction::min);
  if (stop && lowest == static_cast<std::uint64_t>(exchange.rank())) {
    fmt::print("{}", stop->out);
    fmt::print(stderr, "{}", stop->err);
  }
  code = static_cast<int>(values[1]);
  return values[0] != 0;
}

/// Returns the exit code, the same on all ranks.
int run(distributed::MpiExchange& exchange, int argc, char** argv) {
  if (exchange.rank() != 0) Progress::silence();
  Registry registry = Registry::standard();
  add_peers(registry);
  add_paper2011(registry);
  turn_off_hdf5_messages();
  std::signal(SIGXFSZ, SIG_IGN);
  CLI::App app("Contacts between deforming volume meshes, by the processes of mpirun.", "volccd-mpi");
  app.set_version_flag("--version", fmt::format("volccd-mpi {} ({})", build_facts().version, build_facts().commit));
  app.require_subcommand(1);
  Options options;
  add_detect(app, options);
  use_help_formatter(app);
  int code = kDone;
  if (any_stops(exchange, parse(app, argc, argv), code)) return code;
  try {
    detect_on_ranks(exchange, options, options.report, registry);
  } catch (const distributed::RankError& error) {
    if (!std::string_view(error.what()).ends_with(kStoppedByUser)) throw;
    if (exchange.rank() == 0) fmt::print(stderr, "volccd-mpi: {}\n", error.what());
    return kInterrupted;
  }
  return kDone;
}

}  // namespace

}  // namespace volccd

int main(int argc, char** argv) {
  return volccd::distributed::run_mpi_program(
      "volccd-mpi", argc, argv,
      [&](volccd::distributed::MpiExchange& exchange) { return volccd::run(exchange, argc, argv); });
}
