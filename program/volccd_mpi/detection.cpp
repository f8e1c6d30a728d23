#include <volccd/program/volccd_mpi/detection.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <volccd/distributed/agreement.hpp>
#include <volccd/distributed/detector.hpp>
#include <volccd/distributed/global_order.hpp>
#include <volccd/experiments/tables/text_table.hpp>
#include <volccd/io/contacts_csv.hpp>
#include <volccd/io/stats_json.hpp>
#include <volccd/program/output_plan.hpp>
#include <volccd/program/progress.hpp>
#include <volccd/program/rank_table.hpp>
#include <volccd/program/scene_files.hpp>
#include <volccd/program/volccd_mpi/shared_text_file.hpp>
#include <volccd/program/volccd_mpi/step_source.hpp>

namespace volccd {

namespace {

using distributed::Bytes;
using distributed::RankStatistics;
using distributed::Reduction;
using distributed::run_on_all;

ContactRow row_of(int step, const distributed::RankContact& contact) {
  ContactRow row{.step = step,
                 .kind = contact.kind,
                 .ids = contact.vertices,
                 .toi = contact.toi,
                 .normal = contact.normal,
                 .point = contact.point,
                 .has_geometry = true,
                 .at_start = contact.at_start};
  for (std::size_t i = 0; i < 2; ++i) row.sides[i] = {contact.objects[i], contact.elements[i]};
  return row;
}

/// A number of 64 bits whose order is that of the doubles, which are not NaN.
std::uint64_t ordered(double x) {
  const auto bits = std::bit_cast<std::uint64_t>(x == 0 ? 0.0 : x);
  return (bits >> 63) != 0 ? ~bits : bits | (std::uint64_t{1} << 63);
}
double from_ordered(std::uint64_t bits) {
  return std::bit_cast<double>((bits >> 63) != 0 ? bits & ~(std::uint64_t{1} << 63) : ~bits);
}

/// Sums over the ranks and the substeps of one step; `elements` are those of the mesh.
struct StepRow {
  int step = 0;
  std::uint64_t tests = 0, contacts = 0, initial_overlaps = 0, elements = 0;
  double earliest_toi = std::numeric_limits<double>::infinity(), slowest_seconds = 0;
};

class RankDetection {
 public:
  RankDetection(distributed::MpiExchange& exchange, ContactQueryOptions options, const ReportOptions& report,
                const Registry& registry)
      : exchange_(exchange), options_(std::move(options)), report_(report) {
    open();
    make_detector(registry);
  }

  void run() {
    try {
      run_steps_on_ranks();
    } catch (const distributed::RankError&) {
      if (contacts_) contacts_->discard();
      if (overlaps_) overlaps_->discard();
      if (stats_) stats_->discard();
      throw;
    }
    if (first()) print();
  }

 private:
  bool first() const { return exchange_.rank() == 0; }

  void run_steps_on_ranks() {
    if (!options_.contacts.empty()) contacts_.emplace(exchange_, options_.contacts);
    if (!options_.overlaps.empty()) overlaps_.emplace(exchange_, options_.overlaps);
    if (!options_.stats.empty()) stats_.emplace(exchange_, options_.stats);
    if (contacts_) contacts_->write(first() ? contacts_csv_header() : "");
    if (overlaps_) overlaps_->write(first() ? "step,a,b\n" : "");
    Progress progress("detecting", static_cast<std::size_t>(range_.end - range_.begin), "steps");
    for (int k = range_.begin; k < range_.end; ++k) {
      run_step(k);
      progress.advance(static_cast<std::size_t>(k + 1 - range_.begin));
    }
    if (contacts_) contacts_->finish();
    if (overlaps_) overlaps_->finish();
    gather_ranks();
    if (stats_)
      stats_->write(first() ? stats().dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n" : "");
    if (stats_) stats_->finish();
  }

  /// Rank 0 goes first, because it may have to make the sequence of a scene.
  void open() {
    for (const bool turn : {first(), !first()})
      run_on_all(exchange_, "options", [&] {
        if (!turn) return;
        options_.sequence.file = sequence_file(options_.sequence.file);
        OutputPlan plan;
        plan.input("FILE", options_.sequence.file);
        if (first()) plan.output("--contacts", options_.contacts, "all processes write to it");
        if (first()) plan.output("--overlaps", options_.overlaps, "all processes write to it");
        if (first()) plan.output("--stats", options_.stats, "all processes write to it");
        plan.check();
        request_ = options_.request();
        executor_ = make_interruptible_executor(options_.query.threads);
        reader_.emplace(options_.sequence.file);
        if (first()) warn_of_incomplete(*reader_);
        range_ = parse_steps(options_.sequence.steps, reader_->frame_count() - 1, options_.sequence.file);
        options_.check_numbers(range_);
        source_ = make_step_source(*reader_, options_.sequence.config, exchange_.rank(), exchange_.size());
      });
  }

  void make_detector(const Registry& registry) {
    PipelineSpec spec;
    distributed::Config config;
    run_on_all(exchange_, "options", [&] {
      spec = options_.spec(registry);
      config = options_.rank_config(*executor_);
    });
    detector_.emplace(exchange_, registry, spec, config);
  }

  void run_step(int k) {
    bool changed = false;
    run_on_all(exchange_, "reading", [&] {
      InterruptGuard::check();
      changed = source_->go_to(k, *executor_);
    });
    detector_->set_separation(options_.query.separation.value_or(query_separation()));
    if (changed) {
      distributed::Elements elements = source_->elements();
      if (k == range_.begin) check_first_step(k, elements);
      detector_->set_mesh(std::move(elements), source_->vertices(), options_.sequence.config.edge_set);
    }
    rows_.push_back({.step = k});
    const int n = options_.substeps;
    for (int i = 0; i < n; ++i) {
      if (n > 1) part_.set_part(source_->motion(), static_cast<double>(i) / n, static_cast<double>(i + 1) / n);
      const distributed::RankResult& result = detector_->step(n > 1 ? part_ : source_->motion(), request_);
      write(k * n + i, result);
      add_to_row(i, result);
      sum_ += result.rank;
      list_sums_[0] += result.statistics.list_steps;
      list_sums_[1] += result.statistics.refreshed_steps;
      list_sums_[2] += result.statistics.reused_steps;
    }
  }

  /// Of the query of this step: the same on all ranks that have points.
  double query_separation() {
    std::uint64_t greatest = ordered(source_->separation());
    exchange_.allreduce({&greatest, 1}, Reduction::max);
    const double separation = from_ordered(greatest);
    run_on_all(exchange_, "reading", [&] {
      if (source_->motion().vertex_count() > 0 && source_->separation() != separation)
        throw InputError(options_.sequence.file, "VTKHDF/PointData/QuerySeparation",
                         fmt::format("is not the same at all points: {} and {}", source_->separation(), separation));
    });
    return separation;
  }

  /// As QueryOptions::check, with the points of the file in place of the vertices in use.
  void check_first_step(int k, const distributed::Elements& elements) {
    if (options_.query.pairs == PairScope::inter) warn_of_one_object(k, elements);
    const Motion& motion = source_->motion();
    std::vector<std::uint64_t> bounds(6, 0);  // maxima of the coordinates and of their negatives
    for (Index v = 0; v < motion.vertex_count(); ++v)
      for (int c = 0; c < motion.control_points(); ++c)
        for (int i = 0; i < 3; ++i) {
          const double x = motion.point(v, c)[i];
          auto &high = bounds[static_cast<std::size_t>(i)], &low = bounds[static_cast<std::size_t>(i + 3)];
          high = std::max(high, ordered(x));
          low = std::max(low, ordered(-x));
        }
    exchange_.allreduce(bounds, Reduction::max);
    Vec3 size;
    for (std::size_t i = 0; i < 3; ++i)
      size[static_cast<Eigen::Index>(i)] = from_ordered(bounds[i]) + from_ordered(bounds[i + 3]);
    if (const double diagonal = size.stableNorm(); !(detector_->separation() <= diagonal))
      throw distributed::RankError(
          fmt::format("--separation: {:g} is greater than the diagonal {:g} of the box around the scene in step {}: "
                      "all features would be in contact",
                      detector_->separation(), diagonal, k));
  }

  void warn_of_one_object(int k, const distributed::Elements& elements) {
    std::uint64_t lowest = ordered(std::numeric_limits<double>::infinity()), greatest = 0;
    for (const std::int32_t object : elements.objects) {
      lowest = std::min(lowest, ordered(object));
      greatest = std::max(greatest, ordered(object));
    }
    exchange_.allreduce({&lowest, 1}, Reduction::min);
    exchange_.allreduce({&greatest, 1}, Reduction::max);
    if (first() && lowest == greatest)
      fmt::print(stderr,
                 "volccd-mpi: warning: all elements of step {} belong to object {}, so there are no pairs between "
                 "objects; --objects components makes each connected component an object\n",
                 k, from_ordered(lowest));
  }

  void write(int k, const distributed::RankResult& result) {
    if (contacts_) {
      const auto sorted = sort_over_ranks(exchange_, result.contacts);
      std::string text;
      run_on_all(exchange_, "output", [&] {
        for (const distributed::RankContact& contact : sorted)
          append_csv_row(row_of(k, contact), options_.contacts, text);
      });
      contacts_->write(text);
    }
    if (overlaps_) {
      std::string text;
      for (const auto& [a, b] : sort_over_ranks(exchange_, result.initial_overlaps))
        text += fmt::format("{},{},{}\n", k, a, b);
      overlaps_->write(text);
    }
  }

  /// Adds what all ranks found in a substep to the last row.
  void add_to_row(int substep, const distributed::RankResult& result) {
    double earliest = std::numeric_limits<double>::infinity();
    for (const distributed::RankContact& contact : result.contacts) earliest = std::min(earliest, contact.toi);
    std::uint64_t sums[] = {result.contacts.size(), result.rank.tests, result.initial_overlaps.size(),
                            result.rank.elements - result.rank.copies};
    std::uint64_t first_toi = ordered((substep + earliest) / options_.substeps);
    std::uint64_t slowest = static_cast<std::uint64_t>(1e9 * result.rank.seconds);
    exchange_.allreduce(sums, Reduction::sum);
    exchange_.allreduce({&first_toi, 1}, Reduction::min);
    exchange_.allreduce({&slowest, 1}, Reduction::max);
    StepRow& row = rows_.back();
    row.contacts += sums[0];
    row.tests += sums[1];
    row.initial_overlaps += sums[2];
    row.elements = sums[3];
    row.earliest_toi = std::min(row.earliest_toi, from_ordered(first_toi));
    row.slowest_seconds += 1e-9 * static_cast<double>(slowest);
  }

  void gather_ranks() {
    exchange_.allreduce(list_sums_, Reduction::sum);
    const auto* const mine = reinterpret_cast<const std::byte*>(&sum_);
    for (const Bytes& bytes : exchange_.allgather(Bytes(mine, mine + sizeof sum_)))
      std::copy(bytes.begin(), bytes.end(), reinterpret_cast<std::byte*>(&ranks_.emplace_back()));
  }

  nlohmann::json stats() const {
    nlohmann::json steps = nlohmann::json::array();
    for (const StepRow& row : rows_)
      steps.push_back({{"step", row.step},
                       {"elements", row.elements},
                       {"tests", row.tests},
                       {"contacts", row.contacts},
                       {"initial_overlaps", row.initial_overlaps},
                       {"earliest_toi",
                        std::isfinite(row.earliest_toi) ? nlohmann::json(row.earliest_toi) : nlohmann::json(nullptr)},
                       {"slowest_seconds", row.slowest_seconds}});
    return {{"sequence", options_.sequence.file},
            {"query", options_.first ? "first" : "all"},
            {"initial_overlaps", request_.initial_overlaps},
            {"pairs", name_of(options_.query.pairs)},
            {"separation", detector_->separation()},
            {"motion", name_of(options_.sequence.config.motion)},
            {"substeps", options_.substeps},
            {"threads", executor_->workers()},
            {"pipeline", to_json(detector_->pipeline())},
            {"machine", machine_facts()},
            {"ranks", rank_json(ranks_)},
            {"steps", steps}};
  }

  void print() const {
    std::vector<std::string> header = {"step", "tests", "contacts", "earliest t", "slowest rank [ms]"};
    if (overlaps_) header.insert(header.begin() + 3, "initial overlaps");
    TextTable table(header);
    std::uint64_t elements = 0;
    for (const StepRow& row : rows_) {
      std::vector<std::string> cells = {std::to_string(row.step), grouped(row.tests), grouped(row.contacts),
                                        std::isfinite(row.earliest_toi) ? fmt::format("{:.6f}", row.earliest_toi) : "-",
                                        fmt::format("{:.2f}", 1e3 * row.slowest_seconds)};
      if (overlaps_) cells.insert(cells.begin() + 3, grouped(row.initial_overlaps));
      table.add(cells);
      elements += row.elements * static_cast<std::uint64_t>(options_.substeps);
    }
    const Report report(report_);
    report.print("{}: {}, {}, {} ranks with {} thread(s) each\n\n{}\n{}", options_.sequence.file,
                 detector_->pipeline().spec().name, to_string(detector_->pipeline().guarantee()), exchange_.size(),
                 executor_->workers(), table.text(), rank_table(ranks_, elements));
    if (const auto& [made, refreshed, used] = list_sums_; made + refreshed + used > 0)
      report.print("candidate lists, steps of all ranks: {} made one, {} refreshed one, {} used one\n", grouped(made),
                   grouped(refreshed), grouped(used));
    if (contacts_) report.print("\ncontacts written to {}\n", contacts_->name());
    if (overlaps_) report.print("{}initial overlaps written to {}\n", contacts_ ? "" : "\n", overlaps_->name());
    if (stats_) report.print("{}statistics written to {}\n", contacts_ || overlaps_ ? "" : "\n", stats_->name());
  }

  const InterruptGuard guard_;
  distributed::MpiExchange& exchange_;
  ContactQueryOptions options_;
  const ReportOptions& report_;
  Request request_;
  std::unique_ptr<Executor> executor_;
  std::optional<SequenceReader> reader_;
  StepRange range_;
  std::unique_ptr<StepSource> source_;
  Motion part_;  ///< of the motion, in the present substep
  std::optional<distributed::Detector> detector_;
  std::optional<SharedTextFile> contacts_, overlaps_, stats_;
  std::vector<StepRow> rows_;
  RankStatistics sum_;
  std::array<std::uint64_t, 3> list_sums_{};  ///< steps that made a candidate list, refreshed one, used one
  std::vector<RankStatistics> ranks_;         ///< the sums of all ranks, after the last step
};

}  // namespace

void detect_on_ranks(distributed::MpiExchange& exchange, ContactQueryOptions options, const ReportOptions& report,
                     const Registry& registry) {
  RankDetection(exchange, std::move(options), report, registry).run();
}

}  // namespace volccd
