#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <volccd/distributed/in_process_detector.hpp>
#include <volccd/experiments/tables/text_table.hpp>
#include <volccd/io/contact_features.hpp>
#include <volccd/io/contacts_csv.hpp>
#include <volccd/io/contacts_vtp.hpp>
#include <volccd/io/output_file.hpp>
#include <volccd/io/stats_json.hpp>
#include <volccd/pipelines/step_runner.hpp>
#include <volccd/program/commands.hpp>
#include <volccd/program/contact_query_options.hpp>
#include <volccd/program/output_plan.hpp>
#include <volccd/program/progress.hpp>
#include <volccd/program/query_options.hpp>
#include <volccd/program/rank_table.hpp>
#include <volccd/program/report.hpp>
#include <volccd/program/scene_files.hpp>
#include <volccd/program/step_loop.hpp>

namespace volccd {

namespace {

struct DetectOptions : ContactQueryOptions {
  ReportOptions report;
  std::string vtk;
  std::optional<int> ranks;
};

constexpr std::size_t kObjectPairsShown = 20;

std::string time_text(double toi) { return std::isfinite(toi) ? fmt::format("{:.6f}", toi) : "-"; }

/// Milliseconds with three significant digits, or with all digits before the decimal point if there are more.
std::string milliseconds(double seconds) {
  const double value = 1e3 * seconds;
  return fmt::format("{:.{}f}", value, value >= 100 ? 0 : value >= 10 ? 1 : value >= 1 ? 2 : 3);
}

std::vector<std::string> row_of(const std::string& title, const Statistics& s, bool overlaps) {
  std::vector<std::string> row = {title,
                                  grouped(s.element_pairs),
                                  grouped(s.surviving_pairs),
                                  grouped(s.vf_tests),
                                  grouped(s.ee_tests),
                                  grouped(s.contacts),
                                  time_text(s.earliest_toi),
                                  milliseconds(s.seconds)};
  if (overlaps) row.insert(row.begin() + 6, grouped(s.initial_overlaps));
  return row;
}

void print_stages(const Statistics& total, bool overlaps, const Report& report) {
  TextTable table({"stage", "name", "in", "out", "prepare [ms]", "run [ms]", "share [%]"});
  const auto share = [&](double seconds) {
    return fmt::format("{:.1f}", 100 * seconds / std::max(total.seconds, 1e-300));
  };
  double attributed = 0;
  for (const StageStatistics& stage : total.stages) {
    if (stage.role == "initial-overlaps" && !overlaps) continue;
    attributed += stage.all_seconds();
    table.add({stage.role, stage.name, grouped(stage.in), grouped(stage.out), milliseconds(stage.prepare_seconds),
               milliseconds(stage.seconds), share(stage.all_seconds())});
  }
  const double rest = std::max(0.0, total.seconds - attributed);
  table.add({"remainder", "", "", "", "", milliseconds(rest), share(rest)});
  report.print("\n{}", table.text(report.width()));
}

/// Runs the steps and stores the data for the reports.
class Detection {
 public:
  Detection(const DetectOptions& options, const Registry& registry)
      : options_(options),
        executor_(make_interruptible_executor(options.query.threads)),
        runner_(Pipeline(registry, options.spec(registry)),
                {.executor = executor_.get(),
                 .filter = options.query.filter(),
                 .leave_out_shell_neighbours = options.query.leaves_out_shell_neighbours(options.sequence),
                 .lists = options.list_config()}),
        reader_(options.sequence.file),
        stepper_(reader_, options.sequence.config),
        range_(parse_steps(options.sequence.steps, stepper_.step_count(), options.sequence.file)),
        request_(options.request()) {
    if (options.ranks)
      ranks_.emplace(*options.ranks, registry, options.spec(registry), options.rank_config(*executor_));
    options.check_numbers(range_);
    warn_of_incomplete(reader_);
    plan_.input("FILE", options.sequence.file);
    plan_.output("--contacts", options.contacts);
    const bool series = ContactFeaturesWriter::is_series(options.vtk);
    plan_.output("--vtk", options.vtk, series ? ContactFeaturesWriter::kOnlyFiles : nullptr);
    plan_.output("--overlaps", options.overlaps);
    plan_.output("--stats", options.stats);
    if (options.report.json) plan_.output("--json", "-");
    plan_.check();
    if (!options.contacts.empty()) contacts_.emplace(options.contacts);
    if (series)
      features_.emplace(options.vtk);
    else if (!options.vtk.empty())
      vtk_.emplace(options.vtk);
    if (!options.overlaps.empty()) overlaps_.emplace(options.overlaps, "step,a,b");
    if (!options.stats.empty()) stats_.emplace(options.stats);
    report_.emplace(options.report, plan_.report());
  }

  int run() {
    const StepsDone steps = run_steps("detecting", range_, [this](int k) { run_step(k); });
    print_tables();
    StepsDone numbered = steps;  // as steps are numbered in files
    for (int* bound : {&numbered.begin, &numbered.done, &numbered.end}) *bound *= options_.substeps;
    if (contacts_) note(options_.contacts, "contacts", kept(*contacts_, numbered), numbered);
    if (vtk_) note(options_.vtk, "contacts", kept(*vtk_, numbered), numbered);
    if (features_) note(options_.vtk, "features in contact", kept(*features_, numbered), numbered);
    if (overlaps_) note(options_.overlaps, "initial overlaps", kept(*overlaps_, numbered), numbered);
    if (stats_) {
      stats_->write(stats(steps).dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
      stats_->commit();
      note(options_.stats, "statistics", steps, steps);
    }
    if (report_->is_json()) report_->write("detect", stats(steps));
    print_incomplete(steps, report_->people());
    return exit_code(steps);
  }

 private:
  /// Completes a file. Returns the steps that are in it: fewer than the complete ones if the disk is full.
  template <class Writer>
  static StepsDone kept(Writer& writer, const StepsDone& steps) {
    if (!steps.complete()) return writer.finish_incomplete(steps);
    writer.finish();
    return steps;
  }

  /// `in_file`: how many of the `done` steps the file contains.
  void note(const std::string& file, const char* what, const StepsDone& in_file, const StepsDone& done) {
    const char* const first = std::exchange(noted_, true) ? "" : "\n";
    if (in_file.done == in_file.begin)
      report_->print("{}{} could not be written to {}\n", first, what, file);
    else if (in_file.done < done.done)
      report_->print("{}{} written to {} up to step {}\n", first, what, file, in_file.done - 1);
    else
      report_->print("{}{} written to {}\n", first, what, file);
  }

  void run_step(int k) {
    stepper_.go_to(k, *executor_);
    if (k == range_.begin) options_.query.check(stepper_);
    runner_.set_separation(options_.query.separation_in(stepper_));
    if (ranks_) ranks_->set_separation(options_.query.separation_in(stepper_));
    const int n = options_.substeps;
    Statistics sum;
    for (int i = 0; i < n; ++i) {
      if (n > 1) part_.set_part(stepper_.motion(), static_cast<double>(i) / n, static_cast<double>(i + 1) / n);
      run_substep(k, i, n > 1 ? part_ : stepper_.motion());
      Statistics one = result().statistics;
      one.earliest_toi = (i + one.earliest_toi) / n;
      sum += one;
    }
    steps_.push_back(sum);
    total_ += sum;
  }

  void run_substep(int k, int i, const Motion& motion) {
    const Topology& topology = stepper_.topology();
    const int n = options_.substeps, number = k * n + i;
    if (ranks_)
      run_ranks(topology, motion);
    else
      runner_.run(topology, motion, request_);
    const StepResult& result = this->result();
    const double length = (reader_.time(k + 1) - reader_.time(k)) / n, begin = reader_.time(k) + i * length;
    const double end = i + 1 == n ? reader_.time(k + 1) : begin + length;
    if (contacts_) contacts_->write_step(number, result.contacts, topology.mesh());
    if (vtk_) vtk_->write_step(number, begin, end, result.contacts, topology.mesh());
    if (features_) features_->write_step(number, begin, end, result.contacts, topology.mesh(), motion);
    if (overlaps_) overlaps_->write_step(number, overlap_rows(number, result.initial_overlaps));
    count_object_pairs(number, result.contacts, topology.mesh(), object_pairs_);
  }

  void run_ranks(const Topology& topology, const Motion& motion) {
    try {
      ranks_->step(topology, motion, request_);
    } catch (const distributed::RankError&) {
      InterruptGuard::check();  // Ctrl-C ends a rank by an exception
      throw;
    }
    rank_sums_.resize(ranks_->statistics().size());
    for (std::size_t r = 0; r < rank_sums_.size(); ++r) rank_sums_[r] += ranks_->statistics()[r];
    elements_ += topology.mesh().element_count();
  }

  bool leaves_out_shell_neighbours() const { return options_.query.leaves_out_shell_neighbours(options_.sequence); }
  const StepResult& result() const { return ranks_ ? ranks_->result() : runner_.result(); }
  const Pipeline& pipeline() const { return ranks_ ? ranks_->pipeline() : runner_.pipeline(); }

  /// Rows are in ascending order of the pairs of element ids; in each pair, the smaller id is first.
  std::string overlap_rows(int k, const std::vector<ElementPair>& overlaps) const {
    const Mesh& mesh = stepper_.topology().mesh();
    std::vector<std::pair<std::int64_t, std::int64_t>> ids;
    for (const ElementPair pair : overlaps)
      ids.push_back(std::minmax({mesh.element_id(pair.a), mesh.element_id(pair.b)}));
    std::sort(ids.begin(), ids.end());
    std::string rows;
    for (const auto& [a, b] : ids) fmt::format_to(std::back_inserter(rows), "{},{},{}\n", k, a, b);
    return rows;
  }

  void print_tables() {
    std::vector<std::string> header = {"step",     "element pairs", "after culling", "VF tests",
                                       "EE tests", "contacts",      "earliest t",    "time [ms]"};
    if (request_.initial_overlaps) header.insert(header.begin() + 6, "initial overlaps");
    TextTable table(header);
    for (std::size_t i = 0; i < steps_.size(); ++i)
      table.add(row_of(fmt::format("{}", range_.begin + static_cast<int>(i)), steps_[i], request_.initial_overlaps));
    table.rule();
    table.add(row_of("all", total_, request_.initial_overlaps));
    report_->print("{}: {}, {}, {}\n\n{}", options_.sequence.file, pipeline().spec().name,
                   to_string(pipeline().guarantee()), counted(executor_->workers(), "thread"),
                   table.text(report_->width()));
    print_summary();
    if (leaves_out_shell_neighbours()) report_->print("{}\n", kShellNeighboursLeftOut);
    print_object_pairs();
    print_stages(total_, request_.initial_overlaps, *report_);
    if (ranks_) report_->print("\n{}", rank_table(rank_sums_, elements_, report_->width()));
  }

  /// Index into `steps_` of the earliest contact, in the first step that has one; empty if there are no contacts.
  std::optional<std::size_t> earliest_step() const {
    for (std::size_t i = 0; i < steps_.size(); ++i)
      if (std::isfinite(steps_[i].earliest_toi)) return i;
    return std::nullopt;
  }

  void print_summary() {
    if (total_.adjacent_pairs > 0)
      report_->print("\nelement pairs: with {} adjacent ones, elements with themselves included\n",
                     grouped(total_.adjacent_pairs));
    else
      report_->print("\nelement pairs: without adjacent ones\n");
    if (const std::optional<std::size_t> i = earliest_step()) {
      const int k = range_.begin + static_cast<int>(*i);
      const double toi = steps_[*i].earliest_toi;
      report_->print("earliest contact: step {}, t = {:.6f} of the step, time {:.6g}{}\n", k, toi,
                     reader_.time(k) + toi * (reader_.time(k + 1) - reader_.time(k)), time_unit());
    }
    report_->print("contacts at t = 0: {} of {}\n", grouped(total_.contacts_at_start), grouped(total_.contacts));
    if (const std::uint64_t listed = total_.list_steps + total_.refreshed_steps + total_.reused_steps; listed > 0)
      report_->print(
          "{}: {} fresh, {} made a candidate list, {} refreshed one, {} used one; {} tests a list; budget {:.3g} at "
          "most; lists took {} ms\n",
          options_.substeps > 1 ? "substeps" : "steps", grouped(total_.steps - listed), grouped(total_.list_steps),
          grouped(total_.refreshed_steps), grouped(total_.reused_steps), grouped(total_.list_tests / listed),
          total_.list_budget, milliseconds(total_.list_seconds));
  }

  std::string time_unit() const {
    const std::string& unit = reader_.metadata().time_unit;
    return unit.empty() ? unit : " [" + unit + "]";
  }

  std::string object_name(std::int64_t object) const {
    const auto& names = reader_.metadata().object_names;
    const auto found = names.find(static_cast<std::int32_t>(object));
    if (options_.sequence.config.objects != ObjectModel::stored || found == names.end() || found->second.empty())
      return std::to_string(object);
    return fmt::format("{} {}", object, found->second.substr(0, 24));
  }

  /// The pairs with the most contacts.
  void print_object_pairs() const {
    if (object_pairs_.empty() || !report_->for_people()) return;
    std::vector<ObjectPairs::const_pointer> pairs;
    for (const ObjectPairs::value_type& pair : object_pairs_) pairs.push_back(&pair);
    const auto contacts = [](const auto* pair) { return pair->second.vf + pair->second.ee; };
    std::stable_sort(pairs.begin(), pairs.end(),
                     [&](const auto* a, const auto* b) { return contacts(a) > contacts(b); });
    TextTable table({"object", "and object", "VF contacts", "EE contacts", "first in step", "at t"}, 2);
    for (std::size_t i = 0; i < std::min(pairs.size(), kObjectPairsShown); ++i) {
      const auto& [objects, count] = *pairs[i];
      table.add({object_name(objects.first), objects.first == objects.second ? "(itself)" : object_name(objects.second),
                 grouped(count.vf), grouped(count.ee), std::to_string(count.first_step), time_text(count.first_toi)});
    }
    report_->print("\n{}", table.text(report_->width()));
    if (pairs.size() > kObjectPairsShown)
      report_->print("and {} more pairs of objects: --json lists all\n", grouped(pairs.size() - kObjectPairsShown));
  }

  nlohmann::json object_pairs_json() const {
    nlohmann::json pairs = nlohmann::json::array();
    for (const auto& [objects, count] : object_pairs_)
      pairs.push_back({{"objects", {objects.first, objects.second}},
                       {"vf_contacts", count.vf},
                       {"ee_contacts", count.ee},
                       {"first_step", count.first_step},
                       {"first_toi", count.first_toi}});
    return pairs;
  }

  nlohmann::json stats(const StepsDone& done) const {
    nlohmann::json steps = nlohmann::json::array();
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      nlohmann::json entry = to_json(steps_[i]);
      entry["step"] = range_.begin + static_cast<int>(i);
      steps.push_back(std::move(entry));
    }
    return {{"sequence", options_.sequence.file},
            {"complete", done.complete()},
            {"steps_asked", {done.begin, done.end}},
            {"steps_done", done.done - done.begin},
            {"stopped_by", done.complete() ? nlohmann::json(nullptr) : nlohmann::json(done.stopped_by)},
            {"query", options_.first ? "first" : "all"},
            {"initial_overlaps", request_.initial_overlaps},
            {"pairs", name_of(options_.query.pairs)},
            {"objects", name_of(options_.sequence.config.objects)},
            {"separation", options_.query.separation_in(stepper_)},
            {"shells", name_of(options_.sequence.config.shells)},
            {"shell_neighbours", leaves_out_shell_neighbours() ? "leave-out" : "keep"},
            {"edges", name_of(options_.sequence.config.edge_set)},
            {"motion", name_of(options_.sequence.config.motion)},
            {"substeps", options_.substeps},
            {"ranks", ranks_ ? rank_json(rank_sums_) : nlohmann::json(nullptr)},
            {"threads", executor_->workers()},
            {"pipeline", to_json(pipeline())},
            {"machine", machine_facts()},
            {"steps", steps},
            {"earliest_step", earliest_step() ? nlohmann::json(range_.begin + static_cast<int>(*earliest_step()))
                                              : nlohmann::json(nullptr)},
            {"object_pairs", object_pairs_json()},
            {"total", to_json(total_)}};
  }

  const InterruptGuard guard_;  ///< before there are files that an interruption would leave behind
  const DetectOptions& options_;
  std::unique_ptr<Executor> executor_;
  StepRunner runner_;
  std::optional<distributed::InProcessDetector> ranks_;  ///< in place of the runner
  std::vector<distributed::RankStatistics> rank_sums_;
  std::uint64_t elements_ = 0;  ///< of the mesh, in all steps on ranks
  SequenceReader reader_;
  SequenceStepper stepper_;
  Motion part_;  ///< of the motion, in the present substep
  StepRange range_;
  Request request_;
  OutputPlan plan_;
  std::optional<Report> report_;
  std::optional<ContactsCsvWriter> contacts_;
  std::optional<ContactsVtpWriter> vtk_;
  std::optional<ContactFeaturesWriter> features_;
  std::optional<StepTextWriter> overlaps_;
  std::optional<OutputFile> stats_;
  bool noted_ = false;
  std::vector<Statistics> steps_;
  Statistics total_;
  ObjectPairs object_pairs_;
};

}  // namespace

void add_detect_command(CLI::App& app, const Registry& registry, Action& action) {
  CLI::App* command = app.add_subcommand("detect", "contacts of the steps in a sequence");
  const auto options = std::make_shared<DetectOptions>();
  options->add_to(*command);
  command
      ->add_option(
          "--vtk", options->vtk,
          "for ParaView: F.vtp has a point for each contact, with normals, times, kinds, objects; F.pvd is a series "
          "of the features in contact at the end of each step, in F_0000.vtp, ...")
      ->type_name("FILE");
  command
      ->add_option("--ranks", options->ranks,
                   "divide space among N ranks, which run in this process one after another, each on its part of the "
                   "mesh; the contacts are the same")
      ->type_name("N")
      ->check(CLI::Range(1, 4096));
  options->report.add_to(*command);
  command->footer(
      "FILE of an output: with `-` or /dev/stdout, the output goes to the standard output, and the tables go to "
      "stderr; devices and FIFOs are written to, links are followed. After Ctrl-C or an error, the complete steps are "
      "kept: the last line of a CSV file is "
      "then `# incomplete: ...`, in the JSON file \"complete\" is false, and the exit code is 130 or 2.\n"
      "Examples:\n"
      "  volccd detect run.vtkhdf --contacts contacts.csv --stats stats.json\n"
      "  volccd detect run.vtkhdf --vtk contacts.vtp --quiet\n"
      "  volccd detect run.vtkhdf --vtk touching.pvd --quiet\n"
      "  volccd detect run.vtkhdf --steps 4:8 --pipeline NavCCD --threads 2\n"
      "  volccd detect run.vtkhdf --pipeline VolCCD --set csat.axis=optimal --set broad-phase=spatial-hash\n"
      "  volccd detect crash.vtkhdf --shells solid --pairs inter --first\n"
      "  volccd detect run.vtkhdf --motion tentative --stats stats.json\n"
      "  volccd detect crash.vtkhdf --shells solid --shell-neighbours keep --stats stats.json\n"
      "  volccd detect two-bodies.vtkhdf --pairs inter --objects components");
  command->callback([options, &registry, &action] {
    action = [options, &registry] {
      options->sequence.file = sequence_file(options->sequence.file);
      return Detection(*options, registry).run();
    };
  });
}

}  // namespace volccd
