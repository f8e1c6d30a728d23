#include <volccd/program/program.hpp>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>

#include <fmt/format.h>

#include <volccd/io/build_facts.hpp>
#include <volccd/io/hdf5/hdf5_messages.hpp>
#include <volccd/paper2011/paper2011.hpp>
#include <volccd/program/command_line.hpp>
#include <volccd/program/commands.hpp>
#include <volccd/program/scene_files.hpp>

namespace volccd {

namespace {

/// Returns false, with a message, if the standard output could not be written. Otherwise the user would not notice that
/// the report is lost.
bool flush_output() {
  const bool failed = std::ferror(stdout) != 0;
  if (std::fflush(stdout) == 0 && !failed) return true;
  fmt::print(stderr, "volccd: standard output: cannot be written: {}\n", std::strerror(errno));
  return false;
}

}  // namespace

int program(int argc, const char* const* argv, const Registry& own) {
  Registry registry = own;
  add_paper2011(registry);
  turn_off_hdf5_messages();
  CLI::App app("Continuous collision detection between deforming volume meshes: contacts and their first times.",
               "volccd");
  // A limit on the size of files is an error like a full disk, not the end of the process.
  std::signal(SIGXFSZ, SIG_IGN);
  app.set_version_flag("--version", fmt::format("volccd {} ({})", build_facts().version, build_facts().commit));
  app.require_subcommand(1);
  app.footer(
      "Examples:\n"
      "  volccd info run.vtkhdf                         what is in a sequence\n"
      "  volccd detect run.vtkhdf --contacts c.csv      all contacts of all steps\n"
      "  volccd detect run.vtkhdf --steps 3:5 --pipeline NavCCD --stats s.json\n"
      "  volccd verify run.vtkhdf                       all pipelines against each other and against FCL\n"
      "  volccd check csat                              checks the declared properties of one stage\n"
      "  volccd queries ccd-queries.h5                  elementary tests on queries with known answers\n"
      "  volccd report results/ -o report/              tables, figures and scenes in the browser\n"
      "  volccd help COMMAND                            options and examples of a command\n\n"
      "Exit codes: 0 done, 1 verify found a difference, check a broken promise, queries a missed contact,\n"
      "or experiment other contacts or a slower pipeline, 2 bad input or output, 130 interrupted.\n"
      "What was complete before an error or Ctrl-C is kept, and marked as incomplete.");
  Action action;
  add_info_command(app, action);
  add_detect_command(app, registry, action);
  add_verify_command(app, registry, action);
  add_check_command(app, registry, action);
  add_queries_command(app, registry, action);
  add_stages_command(app, registry, action);
  add_scene_command(app, action);
  add_experiment_command(app, registry, action);
  add_report_command(app, registry, action);
  add_view_command(app, registry, action);
  add_help_command(app, registry, action);
  use_help_formatter(app);
  app.failure_message([](const CLI::App* failed, const CLI::Error& error) {
    return "volccd: " + CLI::FailureMessage::simple(failed, error);
  });
  if (argc < 2) {
    fmt::print("{}", short_help(app));
    flush_output();
    return kBadInput;
  }
  try {
    check_command_names(app, argc, argv);
    app.parse(argc, argv);
    const int code = action();
    return flush_output() ? code : kBadInput;
  } catch (const CLI::ExtrasError&) {
    fmt::print(stderr, "volccd: {}\n", unexpected_arguments(app));
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? kDone : kBadInput;
  } catch (const Interrupted& error) {
    fmt::print(stderr, "volccd: {}\n", error.what());
    return kInterrupted;
  } catch (const Error& error) {
    fmt::print(stderr, "volccd: {}\n", error.what());
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "volccd: out of memory\n");
  } catch (const std::exception& error) {
    fmt::print(stderr, "volccd: {}\n", error.what());
  }
  return kBadInput;
}

}  // namespace volccd
