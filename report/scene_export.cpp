#include <volccd/report/scene_export.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numeric>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <volccd/core/error.hpp>
#include <volccd/core/sort_unique.hpp>
#include <volccd/experiments/harness/motion_measures.hpp>
#include <volccd/experiments/tables/catalog.hpp>
#include <volccd/experiments/tables/text_table.hpp>
#include <volccd/io/sequence/reader.hpp>
#include <volccd/io/sequence/stepper.hpp>
#include <volccd/io/stats_json.hpp>
#include <volccd/pictures/contact_marks.hpp>
#include <volccd/pictures/palette.hpp>
#include <volccd/pipelines/step_runner.hpp>
#include <volccd/report/encoding.hpp>
#include <volccd/report/pair_samples.hpp>
#include <volccd/report/surface_track.hpp>

namespace volccd {

namespace {

using nlohmann::json;

constexpr int kSceneSchema = 1;
constexpr int kPairBits = 12;  ///< of a coordinate of a pair's centroid

/// How positions are kept: as many of the 16 bits, and one of so many frames.
struct Coarseness {
  int bits = 16, stride = 1;
};
constexpr std::array<Coarseness, 11> kLadder = {
    {{16, 1}, {14, 1}, {12, 1}, {12, 2}, {12, 3}, {12, 4}, {12, 6}, {12, 8}, {12, 12}, {12, 16}, {12, 32}}};

class Exporter {
 public:
  Exporter(const std::string& name, const std::string& file, const SceneExportConfig& config)
      : name_(name), file_(file), config_(config), reader_(file), hash_(file_hash(file)) {
    if (const std::string& incomplete = reader_.metadata().incomplete; !incomplete.empty())
      notes_.push_back("The sequence is incomplete: " + incomplete + ".");
  }

  ExportedScene run(const Registry& registry, Executor& executor,
                    const std::function<void(std::size_t, std::size_t)>& progress) {
    read_surface();
    read_positions();
    if (config_.pipeline && reader_.frame_count() > 1) run_pipeline(registry, executor, progress);
    encode_triangles();
    fit_pairs();
    fit_positions();
    return finish();
  }

 private:
  /// The marks of a step. Contacts: place and time in 16 bits each, and flags. Pairs: the first centroid, the
  /// zigzag codes of the differences to the second one, and the kind.
  struct Marks {
    std::array<std::vector<std::uint32_t>, 4> columns;
    std::array<std::vector<std::uint32_t>, 6> pair_columns;
    std::vector<std::uint32_t> flags, pair_kinds;
    std::vector<std::vector<SampledPair>> samples;  ///< by stage, and dropped before kept
  };

  /// The frame whose cells the page shows from frame k on: a step uses the cells of its end.
  int cells_frame(int k) const { return std::min(k + 1, reader_.frame_count() - 1); }

  void read_surface() {
    SequenceCells cells;
    for (int k = 0; k < reader_.frame_count(); ++k) {
      if (k > 0 && reader_.same_cells(cells_frame(k - 1), cells_frame(k))) {
        track_.repeat();
        continue;
      }
      reader_.read_cells(cells_frame(k), cells);
      track_.add(cells, reader_.point_count());
    }
    if (track_.triangles().empty())
      throw ConfigError(fmt::format("{}: no step has elements, so that there is nothing to show", file_));
    thin_triangles();
    index_vertices();
  }

  void thin_triangles() {
    const std::size_t before = track_.largest_frame();
    if (before <= config_.max_triangles) return;
    std::vector<Vec3> points;
    reader_.read_points(0, points);
    Eigen::AlignedBox3d box;
    for (const TrackedTriangle& t : track_.triangles())
      for (const Index v : t.corners) box.extend(points[v]);
    double size = box.sizes().norm() / std::sqrt(static_cast<double>(config_.max_triangles));
    SurfaceTrack coarse = track_.clustered(points, size);
    while (coarse.largest_frame() > config_.max_triangles) coarse = track_.clustered(points, size *= 1.3);
    track_ = std::move(coarse);
    notes_.push_back(fmt::format(
        "The surface is thinned: vertices of cells of a grid of {:.3g} {} are joined, so that the largest frame has {} "
        "triangles, where the sequence has {}.",
        size, reader_.metadata().units, grouped(track_.largest_frame()), grouped(before)));
  }

  void index_vertices() {
    for (const TrackedTriangle& t : track_.triangles())
      for (const Index v : t.corners) vertices_.push_back(v);
    sort_unique(vertices_);
  }

  Index compact(Index vertex) const {
    return static_cast<Index>(std::lower_bound(vertices_.begin(), vertices_.end(), vertex) - vertices_.begin());
  }

  /// All frames, and the box around what they show. A vertex that no triangle uses at a frame stays where it was.
  void read_positions() {
    std::vector<Vec3> points;
    std::vector<char> used(reader_.point_count());
    for (int k = 0; k < reader_.frame_count(); ++k) {
      reader_.read_points(k, points);
      std::fill(used.begin(), used.end(), char{0});
      for (const int shown : {std::max(k - 1, 0), k})
        for (const std::uint32_t i : track_.frame(static_cast<std::size_t>(shown)))
          for (const Index v : track_.triangles()[i].corners) used[v] = 1;
      std::vector<Eigen::Vector3f>& frame = frames_.emplace_back(vertices_.size());
      for (std::size_t i = 0; i < vertices_.size(); ++i) {
        const Vec3& p = points[vertices_[i]];
        const bool stays = !used[vertices_[i]] && k > 0;
        frame[i] = stays ? frames_[frames_.size() - 2][i] : Eigen::Vector3f(p.cast<float>());
        if (used[vertices_[i]]) box_.extend(p);
      }
    }
    scale_ = std::max(box_.sizes().maxCoeff(), 1e-300);
  }

  /// The place in the box along an axis, as a number of 16 bits. The same scale for all axes.
  std::uint16_t quantized(double value, int axis, int bits = 16) const {
    const double share = std::clamp((value - box_.min()[axis]) / scale_, 0.0, 1.0);
    return static_cast<std::uint16_t>(std::lround(share * ((1 << bits) - 1)));
  }

  /// The whole script at this coarseness.
  std::string encoded(const Coarseness& coarse) {
    coarse_ = coarse;
    steps_ = kept(coarse.stride);
    encode_topology();
    positions_ = coded_positions();
    return packed();
  }

  std::string coded_positions() {
    std::vector<std::vector<std::uint16_t>> frames;
    for (const int k : steps_) {
      std::vector<std::uint16_t>& frame = frames.emplace_back();
      frame.reserve(3 * vertices_.size());
      for (int axis = 0; axis < 3; ++axis)
        for (const Eigen::Vector3f& p : frames_[static_cast<std::size_t>(k)])
          frame.push_back(quantized(p[axis], axis, coarse_.bits));
    }
    std::string bytes;
    append_frames(bytes, frames, orders_);
    return bytes;
  }

  /// Every stride-th frame, and the last one.
  std::vector<int> kept(int stride) const {
    std::vector<int> steps;
    for (int k = 0; k < reader_.frame_count(); k += stride) steps.push_back(k);
    if (steps.back() != reader_.frame_count() - 1) steps.push_back(reader_.frame_count() - 1);
    return steps;
  }

  /// Chooses the first coarseness with which the script fits.
  void fit_positions() {
    for (const Coarseness& coarse : kLadder) {
      if (coarse.stride > 1 && kept(coarse.stride).size() < 3) break;
      script_ = encoded(coarse);
      if (script_.size() <= config_.max_bytes) break;
    }
    add_coarseness_notes();
    script_ = packed();
  }

  void add_coarseness_notes() {
    if (coarse_.bits < 16)
      notes_.push_back(fmt::format("Positions are rounded to 1/{} of the greatest side of the box around all frames.",
                                   grouped((1u << coarse_.bits) - 1)));
    if (coarse_.stride > 1)
      notes_.push_back(
          fmt::format("{} of the {} frames are shown, one of {}; between them vertices move on straight lines, and the "
                      "contacts are "
                      "those of the first of the {} steps between two frames.",
                      steps_.size(), reader_.frame_count(), coarse_.stride, coarse_.stride));
  }

  void encode_triangles() {
    std::vector<std::uint32_t> values[3], objects, edges;
    std::int32_t before = 0;
    for (const TrackedTriangle& t : track_.triangles()) {
      std::array<std::int32_t, 3> v;
      for (int k = 0; k < 3; ++k) v[k] = static_cast<std::int32_t>(compact(t.corners[k]));
      values[0].push_back(zigzag(v[0] - before));
      values[1].push_back(zigzag(v[1] - v[0]));
      values[2].push_back(zigzag(v[2] - v[0]));
      before = v[0];
      objects.push_back(t.object);
      edges.push_back(t.element_edges);
    }
    for (const auto& column : values) append_planes(triangles_, column, 4);
    append_planes(triangles_, objects, 2);
    append_planes(triangles_, edges, 1);
  }

  /// For each frame shown: which triangles appear and which disappear since the one before.
  void encode_topology() {
    std::vector<std::uint32_t> before, added, removed, deltas;
    topology_.clear(), changes_.clear();
    for (const int k : steps_) {
      const auto now = track_.frame(static_cast<std::size_t>(k));
      added.clear(), removed.clear();
      std::set_difference(now.begin(), now.end(), before.begin(), before.end(), std::back_inserter(added));
      std::set_difference(before.begin(), before.end(), now.begin(), now.end(), std::back_inserter(removed));
      for (const auto* list : {&added, &removed}) {
        std::uint32_t last = 0;
        for (const std::uint32_t i : *list) {
          deltas.push_back(i - last);
          last = i;
        }
      }
      changes_.push_back({added.size(), removed.size()});
      before.assign(now.begin(), now.end());
    }
    change_count_ = deltas.size();
    append_planes(topology_, deltas, 4);
  }

  void run_pipeline(const Registry& registry, Executor& executor,
                    const std::function<void(std::size_t, std::size_t)>& progress) {
    const SequenceStepper::Config elements = table_config(file_);
    StepRunner runner(Pipeline(registry, *config_.pipeline),
                      {.executor = &executor, .leave_out_shell_neighbours = elements.shells == ShellModel::solid});
    SequenceStepper stepper(reader_, elements);
    const int steps = reader_.frame_count() - 1;
    const std::size_t stages = runner.pipeline().spec().stages().size();
    PairSampler sampler(stages, executor.workers(), config_.max_pairs);
    const Request request{.observer = &sampler};
    for (int k = 0; k < steps; ++k) {
      stepper.go_to(k);
      sampler.clear();
      add_step(runner.run(stepper.topology(), stepper.motion(), request), stepper);
      add_pairs(sampler, stages);
      if (progress) progress(static_cast<std::size_t>(k) + 1, static_cast<std::size_t>(steps));
    }
    detection_ = {{"pipeline", to_json(runner.pipeline())},
                  {"shells", name_of(elements.shells)},
                  {"edges", name_of(elements.edge_set)},
                  {"threads", executor.workers()}};
    if (thinned_contacts_)
      notes_.push_back(
          fmt::format("Motions with more than {} contacts show {} of them, spread evenly over the list; "
                      "all are counted.",
                      grouped(config_.max_contacts), grouped(config_.max_contacts)));
  }

  void add_step(const StepResult& result, const SequenceStepper& stepper) {
    std::vector<PictureContact> contacts;
    for (const Contact& contact : result.contacts) contacts.push_back({contact.kind, contact.vertices, contact.point});
    const Mesh& mesh = stepper.topology().mesh();
    classify(contacts, cells_of(mesh), mesh.vertex_count());
    const std::size_t all = contacts.size(), shown = std::min(all, config_.max_contacts);
    thinned_contacts_ = thinned_contacts_ || shown < all;
    Marks& marks = marks_.emplace_back();
    for (std::size_t j = 0; j < shown; ++j) {
      const std::size_t i = j * all / shown;
      const Contact& contact = result.contacts[i];
      for (int axis = 0; axis < 3; ++axis)
        marks.columns[static_cast<std::size_t>(axis)].push_back(quantized(contact.point[axis], axis));
      marks.columns[3].push_back(static_cast<std::uint32_t>(std::lround(contact.toi * 65535)));
      marks.flags.push_back((contact.kind == FeatureKind::ee ? 1u : 0u) | (contacts[i].inter ? 2u : 0u) |
                            (contact.at_start ? 4u : 0u));
    }
    const auto inter = std::count_if(contacts.begin(), contacts.end(), [](const auto& c) { return c.inter; });
    json stats = to_json(result.statistics);
    stats.erase("workspace_bytes"), stats.erase("steps");
    motions_.push_back({{"shown", shown}, {"inter", inter}, {"stats", std::move(stats)}});
  }

  /// Adds to the last step, for each stage, the pairs that it dropped, then those that it kept.
  void add_pairs(const PairSampler& sampler, std::size_t stages) {
    for (std::size_t stage = 0; stage < stages; ++stage)
      for (const bool kept : {false, true}) marks_.back().samples.push_back(sampler.sample(stage, kept));
  }

  /// Chooses how many pairs of each stage and outcome are shown: at most max_pairs, and fewer where they would take
  /// more than a sixth of the script.
  void fit_pairs() {
    steps_ = kept(1);
    for (std::size_t capacity = config_.max_pairs;; capacity = capacity * 3 / 4) {
      std::string bytes;
      for (std::size_t k = 0; k < marks_.size(); ++k) show_pairs(k, capacity);
      append_pairs(bytes);
      if (capacity <= 1 || deflated(bytes).size() * 4 / 3 <= config_.max_bytes / 6) return;
    }
  }

  void show_pairs(std::size_t step, std::size_t capacity) {
    Marks& marks = marks_[step];
    for (auto& column : marks.pair_columns) column.clear();
    marks.pair_kinds.clear();
    json counts = json::array();
    for (std::size_t i = 0; i < marks.samples.size(); ++i) {
      const std::size_t shown = std::min(capacity, marks.samples[i].size());
      for (std::size_t pair = 0; pair < shown; ++pair) add_pair(marks, marks.samples[i][pair]);
      if (i % 2 == 0) counts.push_back(json::array());
      counts.back().push_back(shown);
    }
    motions_[step]["pairs"] = std::move(counts);
  }

  void add_pair(Marks& marks, const SampledPair& pair) const {
    for (int axis = 0; axis < 3; ++axis) {
      const std::int32_t from = quantized(pair.centroids[0][axis], axis, kPairBits),
                         to = quantized(pair.centroids[1][axis], axis, kPairBits);
      marks.pair_columns[static_cast<std::size_t>(axis)].push_back(static_cast<std::uint32_t>(from));
      marks.pair_columns[3 + static_cast<std::size_t>(axis)].push_back(zigzag(to - from));
    }
    marks.pair_kinds.push_back(static_cast<std::uint32_t>(pair.kind));
  }

  void append_pairs(std::string& bytes) const {
    for (std::size_t column = 0; column < 6; ++column)
      append_steps(
          bytes, 2, [&](const Marks& marks) -> const auto& { return marks.pair_columns[column]; });
    append_steps(
        bytes, 1, [](const Marks& marks) -> const auto& { return marks.pair_kinds; });
  }

  /// Calls visit(k) for the steps that begin at a frame that is shown.
  template <class Visitor>
  void for_each_step_shown(Visitor&& visit) const {
    for (std::size_t i = 0; i + 1 < steps_.size(); ++i)
      if (static_cast<std::size_t>(steps_[i]) < marks_.size()) visit(static_cast<std::size_t>(steps_[i]));
  }

  json objects() const {
    std::vector<std::int32_t> ids;
    for (const TrackedObject& object : track_.objects()) ids.push_back(object.id);
    std::sort(ids.begin(), ids.end());
    json list = json::array();
    for (const TrackedObject& object : track_.objects()) {
      const Colour c =
          object_colour(static_cast<std::size_t>(std::lower_bound(ids.begin(), ids.end(), object.id) - ids.begin()));
      const auto& names = reader_.metadata().object_names;
      const auto name = names.find(object.id);
      list.push_back({{"id", object.id},
                      {"name", name == names.end() ? fmt::format("object {}", object.id) : name->second},
                      {"colour", fmt::format("#{:02x}{:02x}{:02x}", c.r, c.g, c.b)},
                      {"solid", object.solid}});
    }
    return list;
  }

  json header() const {
    const SequenceMetadata& metadata = reader_.metadata();
    json motions = json::array();
    std::size_t mark_count = 0, pair_count = 0;
    for_each_step_shown([&](std::size_t k) {
      motions.push_back(motions_[k]);
      mark_count += marks_[k].flags.size();
      pair_count += marks_[k].pair_kinds.size();
    });
    json frames = json::array();
    for (std::size_t i = 0; i < steps_.size(); ++i)
      frames.push_back({{"step", steps_[i]},
                        {"time", reader_.time(steps_[i])},
                        {"cells", reader_.cell_count(steps_[i])},
                        {"order", orders_[i]},
                        {"added", changes_[i][0]},
                        {"removed", changes_[i][1]}});
    const Vec3 low = box_.min(), size = box_.sizes();
    return {
        {"schema", kSceneSchema},
        {"name", name_},
        {"file", std::filesystem::path(file_).filename().string()},
        {"fnv1a", hash_},
        {"title", metadata.title},
        {"source", metadata.source},
        {"license", metadata.license},
        {"units", metadata.units},
        {"time_unit", metadata.time_unit},
        {"steps", reader_.frame_count()},
        {"box", {{"low", {low.x(), low.y(), low.z()}}, {"size", {size.x(), size.y(), size.z()}}, {"scale", scale_}}},
        {"bits", coarse_.bits},
        {"stride", coarse_.stride},
        {"vertices", vertices_.size()},
        {"triangles", track_.triangles().size()},
        {"changes", change_count_},
        {"marks", mark_count},
        {"pairs", pair_count},
        {"pair_bits", kPairBits},
        {"objects", objects()},
        {"frames", std::move(frames)},
        {"motions", std::move(motions)},
        {"detection", detection_},
        {"made", made_},
        {"notes", notes_}};
  }

  /// One column of the marks of all steps that are shown.
  template <class Column>
  void append_steps(std::string& bytes, int width, Column&& column) const {
    std::vector<std::uint32_t> values;
    for_each_step_shown([&](std::size_t k) {
      const std::vector<std::uint32_t>& of_step = column(marks_[k]);
      values.insert(values.end(), of_step.begin(), of_step.end());
    });
    append_planes(bytes, values, width);
  }

  std::string packed() const {
    const std::string text = header().dump(-1, ' ', false, json::error_handler_t::replace);
    std::string bytes;
    const std::uint32_t length = static_cast<std::uint32_t>(text.size());
    append_planes(bytes, std::span(&length, 1), 4);
    bytes += text + triangles_ + topology_ + positions_;
    for (std::size_t column = 0; column < 4; ++column)
      append_steps(
          bytes, 2, [&](const Marks& marks) -> const auto& { return marks.columns[column]; });
    append_steps(
        bytes, 1, [](const Marks& marks) -> const auto& { return marks.flags; });
    append_pairs(bytes);
    return fmt::format("volccd_scene({}, \"{}\");\n", json(name_).dump(), base64(deflated(bytes)));
  }

  ExportedScene finish() {
    const json head = header();
    ExportedScene scene;
    scene.script = std::move(script_);
    for (const char* key :
         {"name", "file", "fnv1a", "title", "source", "license", "steps", "stride", "vertices", "notes"})
      scene.summary[key] = head.at(key);
    scene.summary["frames"] = steps_.size();
    scene.summary["triangles"] = track_.largest_frame();
    scene.summary["elements"] = reader_.cell_count(0);
    scene.summary["bytes"] = scene.script.size();
    std::uint64_t contacts = 0;
    for (const json& motion : head.at("motions")) contacts += motion.at("stats").at("contacts").get<std::uint64_t>();
    scene.summary["contacts"] = contacts;
    return scene;
  }

  const std::string name_, file_;
  const SceneExportConfig& config_;
  SequenceReader reader_;
  SurfaceTrack track_;
  std::vector<Index> vertices_;  ///< slots that triangles use, ascending
  std::vector<std::vector<Eigen::Vector3f>> frames_;
  Eigen::AlignedBox3d box_;
  double scale_ = 1;
  Coarseness coarse_;
  std::vector<int> steps_, orders_;
  std::string positions_, triangles_, topology_;
  std::vector<std::array<std::size_t, 2>> changes_;
  std::size_t change_count_ = 0;
  std::vector<Marks> marks_;  ///< by step of the file; empty without detection
  bool thinned_contacts_ = false;
  json motions_ = json::array(), detection_ = nullptr;
  const json made_ = machine_facts();
  const std::string hash_;
  std::string script_;
  std::vector<std::string> notes_;
};

}  // namespace

ExportedScene export_scene(const std::string& name, const std::string& file, const Registry& registry,
                           const SceneExportConfig& config, Executor& executor,
                           const std::function<void(std::size_t, std::size_t)>& progress) {
  return Exporter(name, file, config).run(registry, executor, progress);
}

}  // namespace volccd
