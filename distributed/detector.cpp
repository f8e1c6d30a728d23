#include <volccd/distributed/detector.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include <volccd/core/sort_unique.hpp>
#include <volccd/distributed/detail/bytes.hpp>
#include <volccd/distributed/detail/imbalance.hpp>
#include <volccd/distributed/detail/lists.hpp>
#include <volccd/distributed/piece_mesh.hpp>
#include <volccd/distributed/region_filter.hpp>
#include <volccd/pipelines/stage_clock.hpp>

namespace volccd::distributed {

namespace {

/// The pipeline with the filter of the region as the last one.
Pipeline make_pipeline(Registry registry, PipelineSpec spec) {
  registry.add(describe_region_filter());
  spec.feature_filters.push_back({"region"});
  Pipeline pipeline(registry, spec);
  if (pipeline.guarantee() == Guarantee::approximate)
    throw ConfigError(
        fmt::format("pipeline {} may lose contacts, and other ones on other numbers of ranks", spec.name));
  return pipeline;
}

void check_config(const Config& config) {
  if (!(config.skin >= 0) || !std::isfinite(config.skin))
    throw ConfigError(fmt::format("skin: {} is not a finite number >= 0", config.skin));
  if (std::isnan(config.max_imbalance)) throw ConfigError("max_imbalance: is not a number");
}

/// All that must be the same on all ranks, as text that users understand.
std::string options_text(const Pipeline& pipeline, const Config& config) {
  std::string text = "pipeline " + pipeline.spec().name;
  for (const auto& [role, stage] : pipeline.spec().stages()) {
    text += fmt::format(", {} {}", role, stage->name);
    for (const auto& [name, value] : stage->options) text += fmt::format(" {}={}", name, value);
  }
  text += fmt::format("; separation {}; skin {}; max_imbalance {}; lists {} {} {}; pairs {}", config.separation,
                      config.skin, config.max_imbalance, static_cast<int>(config.lists.use), config.lists.budget,
                      config.lists.steps, static_cast<int>(config.filter.scope()));
  for (const auto& [a, b] : config.filter.excluded()) text += fmt::format(" without {}-{}", a, b);
  if (config.leave_out_shell_neighbours) text += ", without shell neighbours";
  return text;
}

std::string request_text(const Motion& motion, double separation, const Request& request) {
  return fmt::format("{} control points, separation {}, {}{}", motion.control_points(), separation,
                     request.query == Query::first ? "first contact" : "all contacts",
                     request.initial_overlaps ? ", initial overlaps" : "");
}

void check_request(const Request& request) {
  if (request.ends || request.tests || request.candidates || request.observer)
    throw ConfigError("ends of contacts, given tests, candidates and observers are not supported on ranks");
}

RankContact to_rank_contact(const Contact& contact, const Mesh& mesh) {
  RankContact result{.kind = contact.kind,
                     .toi = contact.toi,
                     .normal = contact.normal,
                     .weights = contact.weights,
                     .point = contact.point,
                     .at_start = contact.at_start,
                     .gap = contact.gap};
  for (std::size_t i = 0; i < 4; ++i) result.vertices[i] = mesh.vertex_id(contact.vertices[i]);
  for (std::size_t i = 0; i < 2; ++i) {
    result.elements[i] = mesh.element_id(contact.elements[i]);
    result.objects[i] = mesh.object(contact.elements[i]);
  }
  return result;
}

/// The vertices that are not complete, and their owners; none if there are no volume elements, whose stars alone are
/// classified.
void find_cut(const ReceivedElements& received, std::vector<std::int64_t>& ids, std::vector<int>& owners) {
  if (std::ranges::all_of(received.elements.types, is_shell)) return;
  std::vector<std::pair<std::int64_t, int>> cut;
  for (std::size_t i = 0; i < received.complete.size(); ++i)
    if (received.complete[i] == 0) cut.emplace_back(received.elements.vertices[i], received.owners[i]);
  sort_unique(cut);
  for (const auto& [id, owner] : cut) {
    ids.push_back(id);
    owners.push_back(owner);
  }
}

MotionBox start_box(const Mesh& mesh, Index element, const Motion& motion) {
  MotionBox box;
  extend(box, motion, mesh.vertices(element), 1);
  return box;
}

}  // namespace

struct Detector::State {
  State(Exchange& exchange_, const Config& config_)
      : exchange(exchange_),
        config(config_),
        executor(config.executor ? *config.executor : serial_executor()),
        imbalance(config.max_imbalance) {}

  void check_step(const Motion& own, const Request& request);
  bool lists_hold() const;
  void make_lists();
  void make_piece(const ReceivedElements& received);
  void run(const Request& request);
  void collect_result(const Request& request);
  void keep_first();

  Exchange& exchange;
  Config config;
  Executor& executor;
  Region region;  ///< of this rank
  std::optional<StepRunner> runner;

  std::optional<detail::Home> home;  ///< empty before set_mesh()
  Regions regions;
  bool divided = false;    ///< whether `regions` are those of the ranks
  bool cuts_made = false;  ///< in this step
  detail::Imbalance imbalance;

  detail::Targets targets;  ///< the ranks that hold the elements of this rank
  bool lists_made = false;
  std::uint64_t held = 0, copies = 0;  ///< elements in the list that this rank received
  PieceMesh piece;
  PieceMesh::Config piece_config;
  detail::VertexImport import;  ///< of the vertices of the piece
  bool import_made = false;
  const Motion* motion = nullptr;  ///< of the piece, in this step

  RankResult result;
  Motion straight;
};

Detector::Detector(Exchange& exchange, const Registry& registry, const PipelineSpec& spec, const Config& config)
    : state_(std::make_unique<State>(exchange, config)) {
  State& s = *state_;
  run_on_all(exchange, "options", [&] {
    check_config(config);
    s.runner.emplace(make_pipeline(registry, spec),
                     RunConfig{.executor = &s.executor,
                               .separation = config.separation,
                               .filter = config.filter,
                               .leave_out_shell_neighbours = config.leave_out_shell_neighbours,
                               .lists = config.lists});
  });
  require_same(exchange, "options", options_text(s.runner->pipeline(), config));
}

Detector::~Detector() = default;
Detector::Detector(Detector&&) noexcept = default;
Detector& Detector::operator=(Detector&&) noexcept = default;

const RankResult& Detector::result() const { return state_->result; }
const Regions& Detector::regions() const { return state_->regions; }
const Pipeline& Detector::pipeline() const { return state_->runner->pipeline(); }
double Detector::separation() const { return state_->runner->separation(); }
void Detector::set_separation(double separation) { state_->runner->set_separation(separation); }

void Detector::set_mesh(Elements elements, std::vector<std::int64_t> vertices, EdgeSet edge_set) {
  detail::Home home(state_->exchange, std::move(elements), std::move(vertices), edge_set);
  state_->home = std::move(home);
  state_->lists_made = state_->import_made = false;
  state_->piece.clear();
}

void Detector::edit(std::span<const std::int64_t> removed, std::span<const std::int64_t> new_vertices,
                    const Elements& added) {
  Elements elements;
  std::vector<std::int64_t> vertices;
  run_on_all(state_->exchange, "edit", [&] {
    if (!state_->home) throw ConfigError("a mesh must be set before it is edited");
    const Elements& present = state_->home->elements();
    const detail::IdTable table(present.ids);
    std::vector<char> gone(present.size(), 0);
    for (std::size_t i = 0; i < removed.size(); ++i) {
      const Index at = table.find(removed[i]);
      if (at == kNone || gone[at] != 0)
        throw InputError(
            "edit", "removed", static_cast<std::int64_t>(i),
            fmt::format("this rank has no element with id {}{}", removed[i], at == kNone ? "" : " any more"));
      gone[at] = 1;
    }
    for (std::size_t i = 0; i < present.size(); ++i)
      if (gone[i] == 0) elements.add(present, i);
    for (std::size_t i = 0; i < added.size(); ++i) elements.add(added, i);
    vertices = state_->home->vertices();
    vertices.insert(vertices.end(), new_vertices.begin(), new_vertices.end());
  });
  set_mesh(std::move(elements), std::move(vertices), state_->home->edge_set());
}

const RankResult& Detector::step(std::span<const Vec3> x0, std::span<const Vec3> x1, const Request& request) {
  run_on_all(state_->exchange, "step", [&] { state_->straight.set_linear(x0, x1); });
  return step(state_->straight, request);
}

const RankResult& Detector::step(const Motion& own, const Request& request) {
  State& s = *state_;
  s.check_step(own, request);
  s.result = {};
  RankStatistics& rank = s.result.rank;
  const bool lists_before = std::exchange(s.lists_made, false);  // if this step fails, the next makes everything anew
  s.home->update(own);
  rank.bytes_received = s.home->bytes_received();
  std::uint64_t anew = 0;
  run_on_all(s.exchange, "step",
             [&] {
               StageClock clock;
               const StageTimer timer(clock, rank.piece_seconds);
               s.home->make_boxes(s.runner->separation(), s.executor);
               anew = lists_before && s.divided && s.lists_hold() ? 0 : 1;
             },
             {&anew, 1});
  if (anew != 0) s.make_lists();
  s.motion = &s.import.update(own);
  rank.bytes_received += s.import.bytes_received();
  rank.neighbours = s.import.neighbours();
  rank.lists = anew;
  run_on_all(s.exchange, "step", [&] { s.run(request); });
  s.collect_result(request);
  if (request.query == Query::first) s.keep_first();
  s.imbalance.add_step(s.exchange, rank.seconds, rank.seconds + rank.piece_seconds, rank.elements,
                       std::exchange(s.cuts_made, false));
  s.lists_made = !s.imbalance.needs_cuts();
  return s.result;
}

void Detector::State::check_step(const Motion& own, const Request& request) {
  const std::string text = request_text(own, runner->separation(), request);
  std::uint64_t hash = 0;
  for (const char c : text) hash = hash * 1099511628211u + static_cast<unsigned char>(c);
  std::uint64_t extremes[2] = {hash, ~hash};
  run_on_all(
      exchange, "step",
      [&] {
        check_request(request);
        if (!home) throw ConfigError("a mesh must be set before the first step");
        if (own.vertex_count() != home->vertices().size())
          throw InputError(
              "step", "motion",
              fmt::format("moves {} vertices, this rank has {}", own.vertex_count(), home->vertices().size()));
      },
      extremes);
  if (extremes[0] != ~extremes[1]) require_same(exchange, "request of a step", text);
}

/// Whether the lists have all elements that ranks need now, and not many more.
bool Detector::State::lists_hold() const {
  return targets.cover(*home, regions) && !targets.too_many(*home, config.skin, regions);
}

/// Divides space if that is due, gives elements to ranks, and makes the piece of this rank if the present one does not
/// serve.
void Detector::State::make_lists() {
  double& seconds = result.rank.piece_seconds;
  std::vector<MotionBox> boxes;
  {
    StageClock clock;
    const StageTimer timer(clock, seconds);
    boxes = home->element_boxes(executor);
  }
  if (!divided || imbalance.needs_cuts()) {
    const std::vector<double> density = divided ? imbalance.density(exchange) : std::vector<double>();
    regions = detail::divide(exchange, boxes, regions, density);
    region = regions.region(exchange.rank());
    divided = cuts_made = true;
  }
  {
    StageClock clock;
    const StageTimer timer(clock, seconds);
    targets = detail::Targets(*home, boxes, config.skin, regions);
  }
  const ReceivedElements received = detail::distribute(exchange, *home, boxes, targets, regions, seconds);
  held = received.elements.size();
  copies = received.copies;
  result.rank.bytes_received += received.bytes;
  piece_config = {config.leave_out_shell_neighbours ? 3 : 1, home->edge_set()};
  make_piece(received);
}

/// Makes the piece of this rank, if the present one does not serve.
void Detector::State::make_piece(const ReceivedElements& received) {
  double& seconds = result.rank.piece_seconds;
  bool serves = false;
  std::uint64_t changed = 0;
  std::vector<std::int64_t> cut;  // vertices without all elements
  std::vector<int> owners;
  run_on_all(exchange, "step",
             [&] {
               StageClock clock;
               const StageTimer timer(clock, seconds);
               serves = piece.serves(received.elements, piece_config);
               changed = serves ? 0 : 1;
               if (!serves && runner->pipeline().uses_cut_stars()) find_cut(received, cut, owners);
             },
             {&changed, 1});
  if (changed == 0 && import_made) return;
  import_made = false;
  const ReceivedElements stars = detail::elements_at(exchange, *home, cut, owners, seconds);
  result.rank.bytes_received += stars.bytes;
  run_on_all(exchange, "step", [&] {
    StageClock clock;
    const StageTimer timer(clock, seconds);
    if (!serves) piece.build(received, stars, piece_config, executor);
  });
  const std::span<const std::int64_t> wanted = piece.empty() ? std::span<const std::int64_t>() : piece.vertex_ids();
  import = detail::VertexImport(exchange, wanted, piece.owners(), home->own());
  import_made = true;
}

void Detector::State::run(const Request& request) {
  if (piece.empty()) return;
  Piece own = piece.piece();
  own.region = region;
  runner->run(piece.topology(), *motion, request, 1, own);
}

/// What the pipeline found, with ids.
void Detector::State::collect_result(const Request& request) {
  result.rank.elements = held;
  result.rank.copies = copies;
  result.rank.halo = piece.halo();
  if (piece.empty()) return;
  const StepResult found = runner->release_result();
  result.statistics = found.statistics;
  result.rank.tests = found.statistics.tests();
  result.rank.contacts = found.contacts.size();
  result.rank.seconds = found.statistics.seconds;
  const Mesh& mesh = piece.topology().mesh();
  for (const Contact& contact : found.contacts) result.contacts.push_back(to_rank_contact(contact, mesh));
  if (!request.initial_overlaps) return;
  for (const ElementPair pair : found.initial_overlaps) {
    const Vec3 point = reference_point(start_box(mesh, pair.a, *motion).low, start_box(mesh, pair.b, *motion).low,
                                       runner->separation());
    if (!region.contains(point)) continue;
    const auto [a, b] = std::minmax({mesh.element_id(pair.a), mesh.element_id(pair.b)});
    result.initial_overlaps.push_back({a, b});
  }
  std::ranges::sort(result.initial_overlaps);
}

/// Leaves the earliest contact of all ranks, the first of equal ones in canonical order, on the rank that has it.
void Detector::State::keep_first() {
  const std::vector<Bytes> all = exchange.allgather(to_bytes(result.contacts));
  std::optional<RankContact> first;
  int rank = 0;
  for (std::size_t r = 0; r < all.size(); ++r)
    for (const RankContact& contact : contacts_of(all[r])) {
      if (first && !(contact.toi != first->toi ? contact.toi < first->toi : canonical_less(contact, *first))) continue;
      first = contact;
      rank = static_cast<int>(r);
    }
  if (rank != exchange.rank()) result.contacts.clear();
}

std::vector<RankContact> Detector::to_owners() {
  State& s = *state_;
  std::vector<std::vector<RankContact>> by_rank(static_cast<std::size_t>(s.exchange.size()));
  run_on_all(s.exchange, "to_owners", [&] {
    for (const RankContact& contact : s.result.contacts) {
      std::vector<int> ranks;
      for (const std::int64_t id : contact.vertices) {
        const auto ids = s.piece.vertex_ids();
        ranks.push_back(s.piece.owners()[static_cast<std::size_t>(std::ranges::lower_bound(ids, id) - ids.begin())]);
      }
      sort_unique(ranks);
      for (const int r : ranks) by_rank[static_cast<std::size_t>(r)].push_back(contact);
    }
  });
  std::vector<Bytes> messages;
  for (const std::vector<RankContact>& contacts : by_rank)
    messages.push_back(contacts.empty() ? Bytes() : to_bytes(contacts));
  std::vector<RankContact> result;
  for (const auto& [source, bytes] : send_to_ranks(s.exchange, std::move(messages))) {
    const std::vector<RankContact> contacts = contacts_of(bytes);
    result.insert(result.end(), contacts.begin(), contacts.end());
  }
  std::ranges::sort(result, [](const RankContact& x, const RankContact& y) { return canonical_less(x, y); });
  return result;
}

}  // namespace volccd::distributed
