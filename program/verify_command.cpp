#include <cmath>
#include <cstdio>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <volccd/experiments/tables/text_table.hpp>
#include <volccd/experiments/verify/verify.hpp>
#include <volccd/program/commands.hpp>
#include <volccd/program/progress.hpp>
#include <volccd/program/query_options.hpp>
#include <volccd/program/report.hpp>
#include <volccd/program/scene_files.hpp>
#include <volccd/program/step_loop.hpp>

namespace volccd {

namespace {

struct VerifyOptions {
  SequenceOptions sequence;
  QueryOptions query;
  VerifyConfig config;
  ReportOptions report;
  std::vector<std::string> settings;
  bool no_fcl = false, no_truth = false;
};

/// The presets, and VolCCD+ with the given settings if there are any.
Registry with_settings(Registry registry, const std::vector<std::string>& settings) {
  if (settings.empty()) return registry;
  PipelineSpec spec = registry.pipeline("VolCCD+");
  for (const std::string& setting : settings) {
    registry.apply_setting(spec, setting);
    spec.name += " " + setting;
  }
  registry.add_pipeline(std::move(spec));
  return registry;
}

constexpr std::size_t kShownNames = 32;  ///< characters of the names of pipelines in a row of the table
constexpr std::size_t kShown = 5;        ///< differences of a kind shown in full; all are counted

std::string text_of(const ContactRow& row) {
  const auto& v = row.ids;
  return row.kind == FeatureKind::vf ? fmt::format("VF {} | {} {} {} at {:.17g}", v[0], v[1], v[2], v[3], row.toi)
                                     : fmt::format("EE {} {} | {} {} at {:.17g}", v[0], v[1], v[2], v[3], row.toi);
}

void show(const Report& report, const char* what, const std::vector<ContactRow>& rows) {
  for (std::size_t i = 0; i < std::min(rows.size(), kShown); ++i) report.print("    {}: {}\n", what, text_of(rows[i]));
  if (rows.size() > kShown) report.print("    {}: {} more\n", what, rows.size() - kShown);
}

std::vector<ContactRow> rows_of(int k, const std::vector<Contact>& contacts, const Mesh& mesh) {
  std::vector<ContactRow> rows;
  for (const Contact& contact : contacts) rows.push_back(contact_row(k, contact, mesh));
  return rows;
}

void show(const Report& report, int k, const std::string& what, const std::vector<ElementPair>& pairs,
          const Mesh& mesh) {
  if (pairs.empty()) return;
  report.print("  step {}: {}: {} pairs of elements, first {} and {}\n", k, what, pairs.size(),
               mesh.element_id(pairs.front().a), mesh.element_id(pairs.front().b));
}

void show_overlaps(const Report& report, int k, const StepVerdict& verdict, const Mesh& mesh) {
  for (const PipelineVerdict& one : verdict.pipelines) {
    show(report, k, "initial overlaps that " + one.pipeline + " misses", one.missing_overlaps, mesh);
    show(report, k, "initial overlaps that only " + one.pipeline + " lists", one.extra_overlaps, mesh);
  }
  std::vector<ElementPair> missing;
  for (const Overlap& overlap : verdict.initial.missing) missing.push_back(overlap.pair);
  show(report, k, "initial overlaps that only FCL finds", missing, mesh);
  show(report, k, "initial overlaps that are none", verdict.initial.extra, mesh);
}

void show_differences(const Report& report, int k, const StepVerdict& verdict, const Mesh& mesh) {
  for (const PipelineVerdict& one : verdict.pipelines) {
    if (one.difference.empty()) continue;
    report.print("  step {}: {} differs from {}: {} missing, {} extra, {} changed{}\n", k, one.pipeline,
                 verdict.reference, one.difference.missing.size(), one.difference.extra.size(),
                 one.difference.changed.size(),
                 one.held ? "" : "; not counted, because its narrow phase is approximate");
    if (!one.held) continue;
    show(report, "missing", rows_of(k, one.difference.missing, mesh));
    show(report, "extra", rows_of(k, one.difference.extra, mesh));
    std::vector<Contact> changed;
    for (const auto& [expected, found] : one.difference.changed) changed.push_back(found);
    show(report, "changed", rows_of(k, changed, mesh));
  }
  for (std::size_t i = 0; i < std::min(verdict.fcl.violations.size(), kShown); ++i) {
    const OverlapViolation& v = verdict.fcl.violations[i];
    report.print("  step {}: FCL finds elements {} and {} overlapping by {:.3g} at t = {:g}, first contact {}\n", k,
                 mesh.element_id(v.pair.a), mesh.element_id(v.pair.b), v.depth, v.time,
                 std::isfinite(v.first_contact) ? fmt::format("{:.6f}", v.first_contact) : "none");
  }
}

/// Empty if the file has no known answers.
std::optional<TruthVerdict> check_truth(const Report& report, SequenceReader& reader, const Mesh& mesh,
                                        const std::vector<Contact>& contacts, const VerifyConfig& config) {
  const auto truth = read_ground_truth(reader);
  if (!truth) return std::nullopt;
  TruthVerdict verdict = check_against_truth(mesh, contacts, *truth, config.truth_time_tolerance);
  report.print("{}", wrapped(fmt::format("ground truth of step 0: {} pairs touch; {} missing, {} extra, {} with a "
                                         "wrong time (largest error {:.2g})\n",
                                         grouped(verdict.colliding), verdict.missing.size(), verdict.extra.size(),
                                         verdict.wrong_time.size(), verdict.largest_time_error)));
  show(report, "missing", verdict.missing);
  show(report, "extra", verdict.extra);
  show(report, "wrong time", verdict.wrong_time);
  return verdict;
}

nlohmann::json to_json(const TruthVerdict& verdict) {
  return {{"colliding", verdict.colliding},
          {"missing", verdict.missing.size()},
          {"extra", verdict.extra.size()},
          {"wrong_time", verdict.wrong_time.size()},
          {"largest_time_error", verdict.largest_time_error}};
}

nlohmann::json to_json(const PipelineVerdict& one) {
  return {{"pipeline", one.pipeline},
          {"same", one.agrees()},
          {"held", one.held},
          {"refused", one.refused},
          {"missing", one.difference.missing.size()},
          {"extra", one.difference.extra.size()},
          {"changed", one.difference.changed.size()},
          {"missing_overlaps", one.missing_overlaps.size()},
          {"extra_overlaps", one.extra_overlaps.size()}};
}

nlohmann::json to_json(int k, const StepVerdict& verdict) {
  nlohmann::json pipelines = nlohmann::json::array();
  for (const PipelineVerdict& one : verdict.pipelines) pipelines.push_back(to_json(one));
  nlohmann::json entry = {
      {"step", k},
      {"clean", verdict.clean()},
      {"reference", verdict.reference},
      {"contacts", verdict.contacts},
      {"earliest_toi", std::isfinite(verdict.earliest_toi) ? nlohmann::json(verdict.earliest_toi) : nlohmann::json()},
      {"initial_overlaps", verdict.initial_overlaps},
      {"pipelines", pipelines},
      {"fcl", nullptr}};
  if (verdict.fcl.times > 0)
    entry["fcl"] = {{"hits", verdict.fcl.hits},
                    {"violations", verdict.fcl.violations.size()},
                    {"initial_hits", verdict.initial.hits},
                    {"initial_missing", verdict.initial.missing.size()},
                    {"initial_extra", verdict.initial.extra.size()}};
  return entry;
}

std::string fcl_text(const StepVerdict& verdict) {
  if (verdict.fcl.times == 0) return "-";
  return fmt::format("{} of {}", grouped(verdict.fcl.violations.size()), grouped(verdict.fcl.hits));
}

/// The number of listed initial overlaps, and how many of them FCL finds.
std::string overlap_text(const StepVerdict& verdict) {
  if (verdict.fcl.times == 0) return grouped(verdict.initial_overlaps);
  return fmt::format("{} (FCL {})", grouped(verdict.initial_overlaps), grouped(verdict.initial.hits));
}

/// Checks all steps and prints the findings of each.
class Verification {
 public:
  Verification(const VerifyOptions& options, const Registry& registry)
      : options_(options),
        config_(config_of(options)),
        reader_(options.sequence.file),
        stepper_(reader_, options.sequence.config),
        range_(parse_steps(options.sequence.steps, stepper_.step_count(), options.sequence.file)),
        executor_(make_interruptible_executor(options.query.threads)),
        filter_(options.query.filter()),
        leave_out_shell_neighbours_(options.query.leaves_out_shell_neighbours(options.sequence)),
        verifier_(registry, config_),
        // The known answers are valid for surfaces with linear motion and for all pairs.
        truth_fits_(!options.no_truth && options.sequence.config.shells == ShellModel::surface && filter_.trivial() &&
                    options.query.separation.value_or(0) == 0 &&
                    options.sequence.config.edge_set == EdgeSet::triangulated &&
                    options.sequence.config.motion == MotionModel::linear) {
    warn_of_incomplete(reader_);
  }

  int run() {
    const StepsDone steps = run_steps("verifying", range_, [this](int k) { run_step(k); });
    report_.print("{}", table_.text(report_.width()));
    if (leave_out_shell_neighbours_) report_.print("{}\n", kShellNeighboursLeftOut);
    if (!verifier_.skipped_pipelines().empty())
      report_.print("{}", wrapped(fmt::format(
                              "left out, because their narrow phase is approximate (--approximate runs them): {}\n",
                              fmt::join(verifier_.skipped_pipelines(), ", "))));
    const char* const in = steps.complete() ? "" : " in these steps";
    report_.print("{}\n", clean_ ? (steps.complete() ? "clean: no difference" : "no difference in these steps")
                                 : fmt::format("DIFFERENCES FOUND{}", in));
    report_.write("verify", document(steps));
    print_incomplete(steps, report_.people());
    if (!steps.complete()) return exit_code(steps);
    return clean_ ? kDone : kDifferent;
  }

 private:
  static VerifyConfig config_of(const VerifyOptions& options) {
    VerifyConfig config = options.config;
    if (options.no_fcl) config.fcl_times.clear();
    return config;
  }

  nlohmann::json document(const StepsDone& done) const {
    return {{"sequence", options_.sequence.file},
            {"complete", done.complete()},
            {"stopped_by", done.complete() ? nlohmann::json(nullptr) : nlohmann::json(done.stopped_by)},
            {"clean", clean_},
            {"threads", executor_->workers()},
            {"skipped_pipelines", verifier_.skipped_pipelines()},
            {"truth", truth_},
            {"steps", steps_}};
  }

  void run_step(int k) {
    stepper_.go_to(k, *executor_);
    if (k == range_.begin) options_.query.check(stepper_);
    const Mesh& mesh = stepper_.topology().mesh();
    std::vector<Contact> contacts;
    const StepVerdict verdict = verifier_.check({.topology = stepper_.topology(),
                                                 .motion = stepper_.motion(),
                                                 .filter = filter_,
                                                 .separation = options_.query.separation_in(stepper_),
                                                 .leave_out_shell_neighbours = leave_out_shell_neighbours_},
                                                *executor_, &contacts);
    std::string differ;
    for (const PipelineVerdict& one : verdict.pipelines)
      if (!one.agrees()) differ += (differ.empty() ? "" : ", ") + one.pipeline;
    if (differ.size() > kShownNames) differ = differ.substr(0, kShownNames - 3) + "...";
    table_.add({std::to_string(k), verdict.reference, grouped(verdict.contacts),
                std::isfinite(verdict.earliest_toi) ? fmt::format("{:.6f}", verdict.earliest_toi) : "-",
                overlap_text(verdict), differ.empty() ? fmt::format("none of {}", verdict.pipelines.size()) : differ,
                fcl_text(verdict)});
    show_differences(report_, k, verdict, mesh);
    show_overlaps(report_, k, verdict, mesh);
    clean_ = clean_ && verdict.clean();
    steps_.push_back(to_json(k, verdict));
    if (k > 0 || !truth_fits_) return;
    if (const std::optional<TruthVerdict> truth = check_truth(report_, reader_, mesh, contacts, config_)) {
      clean_ = clean_ && truth->clean();
      truth_ = to_json(*truth);
    }
  }

  const InterruptGuard guard_;
  const VerifyOptions& options_;
  const Report report_{options_.report};
  VerifyConfig config_;
  SequenceReader reader_;
  SequenceStepper stepper_;
  StepRange range_;
  std::unique_ptr<Executor> executor_;
  ObjectFilter filter_;
  bool leave_out_shell_neighbours_;
  Verifier verifier_;
  bool truth_fits_;
  bool clean_ = true;
  nlohmann::json steps_ = nlohmann::json::array(), truth_ = nullptr;
  TextTable table_{{"step", "reference", "contacts", "earliest t", "overlaps at 0", "pipelines that differ",
                    "FCL violations of hits"}};
};

}  // namespace

void add_verify_command(CLI::App& app, const Registry& registry, Action& action) {
  CLI::App* command =
      app.add_subcommand("verify", "all pipelines against brute force, FCL and the file's ground truth");
  const auto options = std::make_shared<VerifyOptions>();
  options->sequence.add_to(*command);
  options->query.add_to(*command);
  options->sequence.add_objects_to(*command);
  options->report.add_to(*command);
  command
      ->add_option("--brute-force-limit", options->config.brute_force_limit,
                   "number of elements up to which brute force is the reference; above, it is NavCCD")
      ->capture_default_str();
  command->add_flag(
      "--approximate", options->config.approximate,
      "also run pipelines with an approximate narrow phase; the contacts that they miss are shown but not counted");
  command
      ->add_option("--set", options->settings,
                   "one more pipeline: VolCCD+ with stage.option=value or role=stage[,stage...]; may be repeated")
      ->type_name("X=Y")
      ->allow_extra_args(false);
  command->add_flag("--no-fcl", options->no_fcl, "without the FCL oracle");
  command->add_flag("--no-truth", options->no_truth, "do not compare with the ground truth of the file");
  command->footer(
      "Every registered pipeline must find the contacts of the reference, bit for bit, except for those whose\n"
      "narrow phase is approximate and differs from that of the reference; these run with --approximate only.\n"
      "If FCL finds two elements overlapping at t = 1/4, 1/2, 3/4 or 1, they overlapped at t = 0 or must have\n"
      "a contact by then.\n"
      "All pipelines must list the same initial overlaps, all that FCL finds at t = 0 and none that is clearly apart.\n"
      "Exit code 1 if anything differs. Ctrl-C discards the present step and reports the earlier ones:\n"
      "exit code 130.\n"
      "Examples:\n"
      "  volccd verify run.vtkhdf\n"
      "  volccd verify run.vtkhdf --steps 0:2 --threads 2 --no-fcl\n"
      "  volccd verify run.vtkhdf --motion tentative\n"
      "  volccd verify run.vtkhdf --set broad-phase=spatial-hash --set spatial-hash.cell_size=2");
  command->callback([options, &registry, &action] {
    action = [options, &registry] {
      options->sequence.file = sequence_file(options->sequence.file);
      return Verification(*options, with_settings(registry, options->settings)).run();
    };
  });
}

}  // namespace volccd
