#include <volccd/experiments/scenes/deform.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include <volccd/core/error.hpp>
#include <volccd/core/random.hpp>
#include <volccd/experiments/scenes/stacking.hpp>
#include <volccd/oracle/cases/portable_functions.hpp>

namespace volccd {

namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kGap = 0.5;    // gap between copies, in mean edges
constexpr double kShift = 0.5;  // sideways shift of a copy, in mean edges

struct KindInfo {
  DeformKind kind;
  const char* name;
  const char* unit;
  double low, high;  ///< bounds of the amount
};
constexpr KindInfo kKinds[] = {{DeformKind::twist, "twist", "degrees", -36000, 36000},
                               {DeformKind::bend, "bend", "degrees", -360, 360},
                               {DeformKind::squeeze, "squeeze", "of the length", -10, 0.99},
                               {DeformKind::jitter, "jitter", "mean edges", 0, 1000},
                               {DeformKind::collide, "collide", "mean edges", 0, 1000}};

const KindInfo& info(DeformKind kind) {
  return *std::find_if(std::begin(kKinds), std::end(kKinds), [&](const KindInfo& k) { return k.kind == kind; });
}

/// Lengths of a mesh, in which the amounts of the motions are measured.
struct Measure {
  Vec3 centre = Vec3::Zero();
  std::array<int, 3> axes = {0, 1, 2};  ///< coordinate axes, in descending order of the extent
  std::array<double, 3> extent{};       ///< along these axes
  double edge = 0;                      ///< mean edge length
};

Measure measure(const Shape& mesh) {
  if (mesh.elements.empty()) throw InputError("mesh", "elements", "there are none, so that nothing can move");
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    if (!mesh.positions[v].allFinite())
      throw InputError("mesh", "positions", static_cast<std::int64_t>(v), "not a finite position");
  Measure m;
  m.edge = mean_edge_length(mesh);
  const Vec3 unset = Vec3::Constant(INFINITY);
  Vec3 low = unset, high = -unset;
  for (const ElementSpec& e : mesh.elements)
    for (const Index v : e.vertices) {
      low = low.cwiseMin(mesh.positions[v]);
      high = high.cwiseMax(mesh.positions[v]);
    }
  const Vec3 size = high - low;
  m.centre = low + size / 2;
  std::stable_sort(m.axes.begin(), m.axes.end(), [&](int a, int b) { return size[a] > size[b]; });
  for (std::size_t i = 0; i < 3; ++i) m.extent[i] = size[m.axes[i]];
  if (!(m.extent[0] > 0) || !(m.edge > 0) || !std::isfinite(m.extent[0]))
    throw InputError("mesh", "positions", "the mesh has no extent, or one beyond the range of numbers");
  return m;
}

/// The amount with which the fastest vertex moves by about one mean edge in each step.
double default_amount(DeformKind kind, const Measure& m, int motions) {
  const double way = m.edge * motions;
  switch (kind) {
    case DeformKind::twist:
      return std::min(180.0, way / (0.25 * portable_hypot(m.extent[1], m.extent[2]) + m.edge / 4) / kDegree);
    case DeformKind::bend: return std::min(180.0, 8 * way / m.extent[0] / kDegree);
    case DeformKind::squeeze: return std::min(0.5, 2 * way / m.extent[0]);
    case DeformKind::jitter: return 0.3;
    case DeformKind::collide: return std::min(4.0, static_cast<double>(motions));
  }
  return 0;
}

void check(const DeformConfig& config) {
  if (config.motions.empty()) throw ConfigError("deform: no motion is given");
  if (config.copies < 1 || config.copies > 10'000) throw ConfigError("deform: copies is not in 1 .. 10000");
  if (config.frames < 2 || config.frames > 100'000) throw ConfigError("deform: frames is not in 2 .. 100000");
  std::map<DeformKind, int> times;
  for (const DeformMotion& motion : config.motions) {
    const KindInfo& kind = info(motion.kind);
    if (++times[motion.kind] > 1) throw ConfigError(fmt::format("deform: {} is given twice", kind.name));
    if (motion.amount && !(*motion.amount >= kind.low && *motion.amount <= kind.high))
      throw ConfigError(fmt::format("deform: {} by {} {} is not in {} .. {}", kind.name, *motion.amount, kind.unit,
                                    kind.low, kind.high));
  }
  if (times[DeformKind::collide] && config.copies < 2) throw ConfigError("deform: collide needs at least two copies");
}

class Deform final : public Scene {
 public:
  Deform(const Shape& mesh, const DeformConfig& config) : config_(config), mesh_(mesh), measure_(measure(mesh)) {
    const std::uint64_t vertices = std::uint64_t{mesh.positions.size()} * static_cast<std::uint64_t>(config.copies);
    if (vertices >= kNone) throw ConfigError(fmt::format("deform: {} copies have too many vertices", config.copies));
    for (DeformMotion& motion : config_.motions)
      if (!motion.amount) motion.amount = default_amount(motion.kind, measure_, config.frames - 1);
    copy_elements();
    place_copies();
    describe();
  }

  const SequenceMetadata& metadata() const override { return metadata_; }
  int frames() const override { return config_.frames; }
  double time(int frame) const override { return frame; }
  Index vertex_count() const override { return static_cast<Index>(mesh_.positions.size()) * copies(); }

  void positions(int frame, std::vector<Vec3>& out) const override {
    out.clear();
    const double s = progress(frame);
    for (Index copy = 0; copy < copies(); ++copy) {
      const Vec3 offset = (1 - s) * start_[copy] + s * end_[copy];
      for (Index v = 0; v < mesh_.positions.size(); ++v) out.push_back(deformed(copy, v, frame) + offset);
    }
  }

  void cells(int, SequenceCells& out) const override { out = cells_; }

 private:
  Index copies() const { return static_cast<Index>(config_.copies); }
  double progress(int frame) const { return static_cast<double>(frame) / (config_.frames - 1); }

  Vec3 deformed(Index copy, Index v, int frame) const {
    const double s = progress(frame), turn = copy % 2 == 0 ? s : -s;
    Vec3 p = mesh_.positions[v];
    for (const DeformMotion& motion : config_.motions) switch (motion.kind) {
        case DeformKind::twist: p = twisted(p, turn * *motion.amount * kDegree); break;
        case DeformKind::bend: p = bent(p, turn * *motion.amount * kDegree); break;
        case DeformKind::squeeze: p = squeezed(p, s * *motion.amount); break;
        case DeformKind::jitter: p += noise(copy, v, frame, *motion.amount * measure_.edge); break;
        case DeformKind::collide: break;  // offsets of the whole copy
      }
    return p;
  }

  Vec3 twisted(const Vec3& p, double angle) const {
    const auto [u, v, w] = measure_.axes;
    const Vec3 d = p - measure_.centre;
    const double a = angle * d[u] / measure_.extent[0];
    Vec3 q = p;
    q[v] = measure_.centre[v] + portable_cos(a) * d[v] - portable_sin(a) * d[w];
    q[w] = measure_.centre[w] + portable_sin(a) * d[v] + portable_cos(a) * d[w];
    return q;
  }

  /// The long axis keeps its length on an arc of radius length / angle.
  Vec3 bent(const Vec3& p, double angle) const {
    if (angle == 0) return p;
    const int u = measure_.axes[0], w = measure_.axes[2];
    const Vec3 d = p - measure_.centre;
    const double radius = measure_.extent[0] / angle, a = d[u] / radius, half = portable_sin(a / 2);
    Vec3 q = p;
    q[u] = measure_.centre[u] + (radius - d[w]) * portable_sin(a);
    q[w] = measure_.centre[w] + d[w] * portable_cos(a) + 2 * radius * half * half;
    return q;
  }

  Vec3 squeezed(const Vec3& p, double fraction) const {
    Vec3 d = p - measure_.centre;
    const double wider = 1 / std::sqrt(1 - fraction);
    d[measure_.axes[0]] *= 1 - fraction;
    d[measure_.axes[1]] *= wider;
    d[measure_.axes[2]] *= wider;
    return measure_.centre + d;
  }

  Vec3 noise(Index copy, Index v, int frame, double amount) const {
    if (frame == 0) return Vec3::Zero();
    const auto key = hash_ids(hash_ids(seed(), static_cast<std::uint64_t>(frame)), (std::uint64_t{copy} << 32) | v);
    Random random(key);
    const double x = random.uniform(-amount, amount), y = random.uniform(-amount, amount);
    return {x, y, random.uniform(-amount, amount)};
  }

  std::uint64_t seed() const { return static_cast<std::uint64_t>(config_.seed); }

  void copy_elements() {
    std::map<std::int32_t, std::int32_t> rank;
    std::int64_t ids = 0;
    for (const ElementSpec& e : mesh_.elements) {
      rank[e.object] = 0;
      ids = std::max(ids, e.id + 1);
    }
    std::int32_t parts = 0;
    for (auto& [object, r] : rank) r = parts++;
    for (Index copy = 0; copy < copies(); ++copy)
      for (ElementSpec e : mesh_.elements) {
        const Index first = copy * static_cast<Index>(mesh_.positions.size());
        e.renumber([&](Index v) { return v + first; });
        e.object = static_cast<std::int32_t>(copy) * parts + rank[e.object];
        e.id += copy * ids;
        cells_.add(e);
      }
  }

  /// Chooses offsets that leave a gap between neighbours in the first frame and, for collide, give an overlap in the
  /// last frame.
  void place_copies() {
    const int up = measure_.axes[2];
    double overlap = 0;
    bool collide = false;
    for (const DeformMotion& motion : config_.motions)
      if (motion.kind == DeformKind::collide) {
        collide = true;
        overlap = *motion.amount * measure_.edge;
      }
    start_.assign(copies(), Vec3::Zero());
    for (Index copy = 0; copy < copies(); ++copy) {
      Random random(hash_ids(seed(), copy));
      for (const int c : {measure_.axes[0], measure_.axes[1]})
        if (copies() > 1) start_[copy][c] = random.uniform(-kShift, kShift) * measure_.edge;
    }
    end_ = start_;
    const auto triangles = face_triangles(mesh_);
    stack(start_, triangles, 0, kGap * measure_.edge, up);
    if (collide)
      stack(end_, triangles, config_.frames - 1, -overlap, up);
    else
      end_ = start_;
  }

  void stack(std::vector<Vec3>& offsets, const std::vector<std::array<Index, 3>>& triangles, int frame, double gap,
             int up) const {
    std::vector<Vec3> below, above;
    for (Index copy = 0; copy < copies() && copies() > 1; ++copy) {
      above.clear();
      for (Index v = 0; v < mesh_.positions.size(); ++v) above.push_back(deformed(copy, v, frame) + offsets[copy]);
      if (copy > 0) {
        const double shift = touching_shift(below, above, triangles, up, measure_.edge) + gap;
        offsets[copy][up] += shift;
        for (Vec3& p : above) p[up] += shift;
      }
      std::swap(below, above);
    }
    const double middle = (offsets.front()[up] + offsets.back()[up]) / 2;
    for (Vec3& offset : offsets) offset[up] -= middle;
  }

  void describe() {
    std::string motions;
    for (const DeformMotion& motion : config_.motions)
      motions += fmt::format("{}{} {:.6g} {}", motions.empty() ? "" : ", ", info(motion.kind).name, *motion.amount,
                             info(motion.kind).unit);
    metadata_.title = fmt::format("Made-up motion: {}", motions);
    metadata_.source = fmt::format("volccd scene deform, {} elements, {} {}, seed {}", mesh_.elements.size(),
                                   config_.copies, config_.copies == 1 ? "copy" : "copies", config_.seed);
  }

  DeformConfig config_;
  Shape mesh_;
  Measure measure_;
  SequenceCells cells_;
  std::vector<Vec3> start_, end_;  ///< [copy]
  SequenceMetadata metadata_;
};

double parse_amount(const std::string& kind, const std::string& text) {
  return detail::parse_number("amount of " + kind, text, -1e6, 1e6);
}

DeformKind parse_kind(const std::string& text) {
  std::string known;
  for (const KindInfo& k : kKinds) {
    if (text == k.name) return k.kind;
    known += (known.empty() ? "" : ", ") + std::string(k.name);
  }
  throw ConfigError("deform: no motion is called \"" + text + "\"; there are: " + known);
}

const Options<DeformConfig>& deform_options() {
  static const auto options =
      Options<DeformConfig>()
          .add("copies", &DeformConfig::copies, 1, 10'000, "copies of the mesh, separate objects")
          .add("frames", &DeformConfig::frames, 2, 100'000, "frames of the sequence: 2 make one step")
          .add("seed", &DeformConfig::seed, 0, 1'000'000'000, "for sideways shifts and jitter");
  return options;
}

std::unique_ptr<Scene> make_from_options(OptionValues values, const Shape* mesh) {
  std::string motion = "twist";
  std::optional<double> amount;
  if (const auto given = values.extract("motion")) motion = given.mapped();
  if (const auto given = values.extract("amount")) amount = parse_amount("the motion", given.mapped());
  DeformConfig config = deform_options().parse(values);
  config.motions = parse_deform_motions(motion, amount);
  return make_deform(*mesh, config);
}

}  // namespace

std::vector<DeformMotion> parse_deform_motions(const std::string& text, const std::optional<double>& amount) {
  std::vector<DeformMotion> motions;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string item = text.substr(begin, end - begin);
    const std::size_t colon = std::min(item.find(':'), item.size());
    DeformMotion motion{parse_kind(item.substr(0, colon))};
    if (colon < item.size()) motion.amount = parse_amount(item.substr(0, colon), item.substr(colon + 1));
    motions.push_back(motion);
    begin = end + 1;
  }
  if (amount) {
    if (motions.size() > 1 || motions.front().amount)
      throw ConfigError("deform: an amount is given for a list of several motions: write \"twist:60,collide:2\"");
    motions.front().amount = amount;
  }
  return motions;
}

std::unique_ptr<Scene> make_deform(const Shape& mesh, const DeformConfig& config) {
  check(config);
  return std::make_unique<Deform>(mesh, config);
}

SceneDescriptor describe_deform() {
  std::vector<OptionInfo> options = {
      {"motion", "twist", "list of twist|bend|squeeze|jitter|collide, each with :amount if given",
       "motions of the mesh, e.g. twist:60,collide:2"},
      {"amount", "", "degrees (twist, bend), fraction of the length (squeeze), mean edges (jitter, collide)",
       "amount of a single motion; default: the fastest vertex moves by about a mean edge in each step"}};
  for (const OptionInfo& option : deform_options().describe()) options.push_back(option);
  return {"deform", "a synthetic motion of any mesh, or of several copies of it", true, options, make_from_options};
}

}  // namespace volccd
