#include <volccd/experiments/tables/feature_sets.hpp>

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <unordered_map>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/experiments/harness/corner_volumes.hpp>
#include <volccd/experiments/records/stats_json.hpp>
#include <volccd/experiments/tables/text_table.hpp>
#include <volccd/mesh/sequence/stepper.hpp>
#include <volccd/pipelines/pipeline.hpp>

namespace volccd {

using nlohmann::json;

namespace {

/// Six times the volume of the tetrahedron at each corner, for as many corners as there are.
struct CornerVolumes {
  std::array<double, 8> at;
  std::size_t count;

  double least() const { return *std::min_element(at.begin(), at.begin() + static_cast<std::ptrdiff_t>(count)); }
  /// All are equal to it in a parallelepiped, and to twice of it in half of one.
  double volume() const {
    return std::accumulate(at.begin(), at.begin() + static_cast<std::ptrdiff_t>(count), 0.0) / (count == 8 ? 8 : 12);
  }
};

/// Of a hexahedron or a wedge in VTK's order.
CornerVolumes corner_volumes(std::span<const Index> v, std::span<const Vec3> x) {
  CornerVolumes volumes{{}, v.size()};
  const auto corners = corner_tetrahedra(v.size() == 8 ? ElementType::hexahedron : ElementType::wedge);
  for (std::size_t i = 0; i < v.size(); ++i) volumes.at[i] = corner_volume(corners[i], v, x);
  return volumes;
}

class Observer {
 public:
  Observer(SequenceReader& reader, Executor& executor)
      : reader_(reader),
        executor_(executor),
        stepper_(reader),
        registry_(Registry::standard()),
        pipeline_(registry_, registry_.pipeline("VolCCD+")),
        workspace_(pipeline_.make_workspace()) {
    SequenceCells cells;
    reader.read_cells(0, cells);
    reader.read_points(0, points_);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      check_type(cells.types[i], i);
      mass_[key(cells.ids[i], cells.types[i])] = corner_volumes(cells.vertices(i), points_).volume();
      striker_ = std::min(striker_, cells.parts[i]);
    }
  }

  json motion(int k) {
    stepper_.go_to(k);
    const Mesh& mesh = stepper_.topology().mesh();
    pipeline_.run({stepper_.topology(), stepper_.motion(), filter_}, workspace_, executor_, result_,
                  {Query::all, true});
    json record = {{"time", reader_.time(k + 1)},
                   {"contacts", result_.contacts.size()},
                   {"interior", interior_contacts()},
                   {"overlaps", overlaps(mesh)},
                   {"pieces", pieces(mesh)}};
    reader_.read_points(k, points_);
    const Vec3 from = centre(mesh);
    reader_.read_points(k + 1, points_);
    const Vec3 step = centre(mesh) - from;
    if (k == 0) direction_ = step.norm() > 0 ? Vec3(step.normalized()) : Vec3(Vec3::UnitZ());
    travel_ += step.dot(direction_);
    record["velocity"] = step.dot(direction_) / (reader_.time(k + 1) - reader_.time(k));
    record["travel"] = travel_;
    record["inverted"] = inverted(mesh);
    return record;
  }

  int motions() const { return stepper_.motion_count(); }

 private:
  void check_type(ElementType type, std::size_t index) const {
    if (type != ElementType::hexahedron && type != ElementType::wedge)
      throw InputError(reader_.file(), "Types", static_cast<std::int64_t>(index), "is no hexahedron, nor half of one");
  }

  CornerVolumes corner_volumes_of(const Mesh& mesh, Index o) const {
    check_type(mesh.type(o), o);
    return corner_volumes(mesh.vertices(o), points_);
  }

  std::size_t interior_contacts() const {
    const Features& features = stepper_.topology().features();
    std::vector<char> vertex(features.vertex_slots(), 0), edge(features.edge_slots(), 0);
    const auto outside = [&](Index f) { return features.triangle_elements(f).size() == 1; };
    for (Index f = 0; f < features.triangle_slots(); ++f) {
      if (!outside(f)) continue;
      const auto& t = features.triangle(f);
      for (std::size_t i = 0; i < 3; ++i) {
        vertex[t[i]] = 1;
        if (const Index e = features.find_edge(t[i], t[(i + 1) % 3]); e != kNone) edge[e] = 1;
      }
    }
    return static_cast<std::size_t>(std::ranges::count_if(result_.contacts, [&](const Contact& c) {
      const auto& v = c.vertices;
      if (c.kind == FeatureKind::vf) return !vertex[v[0]] || !outside(features.find_triangle(v[1], v[2], v[3]));
      return !edge[features.find_edge(v[0], v[1])] || !edge[features.find_edge(v[2], v[3])];
    }));
  }

  json overlaps(const Mesh& mesh) const {
    std::size_t inter = 0;
    for (const ElementPair& pair : result_.initial_overlaps)
      inter += mesh.object(pair.a) != mesh.object(pair.b) ? 1 : 0;
    return {{"inter", inter}, {"intra", result_.initial_overlaps.size() - inter}};
  }

  /// Connected pieces: elements connected by vertices.
  json pieces(const Mesh& mesh) const {
    std::vector<Index> root(mesh.vertex_count());
    std::iota(root.begin(), root.end(), Index{0});
    const auto find = [&](Index v) {
      while (root[v] != v) v = root[v] = root[root[v]];
      return v;
    };
    std::vector<Index> of_striker, of_target;
    for (Index o = 0; o < mesh.element_slots(); ++o)
      if (mesh.is_live(o))
        for (Index v : mesh.vertices(o)) root[find(v)] = find(mesh.vertices(o)[0]);
    for (Index o = 0; o < mesh.element_slots(); ++o)
      if (mesh.is_live(o)) (mesh.object(o) == striker_ ? of_striker : of_target).push_back(find(mesh.vertices(o)[0]));
    const auto distinct = [](std::vector<Index>& roots) {
      std::sort(roots.begin(), roots.end());
      return std::unique(roots.begin(), roots.end()) - roots.begin();
    };
    return {{"striker", distinct(of_striker)}, {"target", distinct(of_target)}};
  }

  /// A piece of an element keeps its id, and is another element all the same.
  static std::int64_t key(std::int64_t id, ElementType type) { return 2 * id + (type == ElementType::wedge ? 1 : 0); }

  Vec3 centre(const Mesh& mesh) {
    Vec3 sum = Vec3::Zero();
    double mass = 0;
    for (Index o = 0; o < mesh.element_slots(); ++o) {
      if (!mesh.is_live(o) || mesh.object(o) != striker_) continue;
      const std::span<const Index> vertices = mesh.vertices(o);
      const auto [at, is_new] = mass_.try_emplace(key(mesh.element_id(o), mesh.type(o)), 0);
      if (is_new) at->second = corner_volumes_of(mesh, o).volume();
      for (Index v : vertices) sum += at->second / static_cast<double>(vertices.size()) * points_[v];
      mass += at->second;
    }
    return mass > 0 ? Vec3(sum / mass) : sum;
  }

  std::size_t inverted(const Mesh& mesh) const {
    std::size_t count = 0;
    for (Index o = 0; o < mesh.element_slots(); ++o)
      if (mesh.is_live(o)) count += corner_volumes_of(mesh, o).least() <= 0 ? 1 : 0;
    return count;
  }

  SequenceReader& reader_;
  Executor& executor_;
  SequenceStepper stepper_;
  Registry registry_;
  Pipeline pipeline_;
  Workspace workspace_;
  ObjectFilter filter_;
  StepResult result_;
  std::vector<Vec3> points_;
  std::unordered_map<std::int64_t, double> mass_;  ///< by key(): volume when first seen
  std::int32_t striker_ = std::numeric_limits<std::int32_t>::max();
  Vec3 direction_ = Vec3::UnitZ();
  double travel_ = 0;
};

template <class Value>
std::uint64_t sum_over(const json& motions, Value&& value) {
  std::uint64_t sum = 0;
  for (const json& motion : motions) sum += value(motion).template get<std::uint64_t>();
  return sum;
}

std::vector<std::string> feature_set_row(const json& record) {
  const json& motions = record.at("motions");
  const json &last = motions.back(), &baked = record.at("simulation");
  std::uint64_t splits = 0;
  if (!baked.is_null())
    for (const json& frame : baked.at("frames")) splits += frame.at("edits").at("splits").get<std::uint64_t>();
  const auto overlaps = [](const json& m, const char* kind) { return m.at("overlaps").at(kind); };
  return {record.at("scene"),
          baked.is_null() ? "-" : grouped(splits),
          grouped(last.at("pieces").at("striker")),
          grouped(last.at("pieces").at("target")),
          fmt::format("{:.0f}", last.at("velocity").get<double>()),
          fmt::format("{:.2f}", 1e3 * last.at("travel").get<double>()),
          grouped(overlaps(last, "inter")),
          grouped(overlaps(last, "intra")),
          grouped(sum_over(motions, [](const json& m) { return m.at("inverted"); })),
          grouped(sum_over(motions, [](const json& m) { return m.at("contacts"); })),
          grouped(sum_over(motions, [](const json& m) { return m.at("interior"); })),
          baked.is_null() ? "-" : duration(baked.at("seconds"))};
}

}  // namespace

std::optional<json> feature_set_record(const std::string& name, const std::string& sequence,
                                       const std::string& bake_record, Executor& executor,
                                       const std::function<bool(std::size_t, std::size_t)>& go_on) {
  json record = read_json_file(bake_record);
  SequenceReader reader(sequence);
  Observer observer(reader, executor);
  json motions = json::array();
  for (int k = 0; k < observer.motions(); ++k) {
    motions.push_back(observer.motion(k));
    if (!go_on(static_cast<std::size_t>(k + 1), static_cast<std::size_t>(observer.motions()))) return std::nullopt;
  }
  return json{{"scene", name},
              {"machine", machine_facts()},
              {"simulation", std::move(record)},
              {"motions", std::move(motions)}};
}

TitledTable feature_set_table(const std::vector<json>& records) {
  TextTable table({"scene", "splits", "pieces, bullet", "pieces, plate", "velocity, m/s", "travel, mm",
                   "overlaps, inter", "overlaps, intra", "inverted", "contacts", "interior contacts", "computed in"});
  for (const json& record : records) table.add(feature_set_row(record));
  return {"", table,
          "pieces, velocity and travel of the bullet's centre, pairs of elements that overlap (exact; not adjacent "
          "ones): at the end; inverted elements, contacts among all features, and those with a feature inside: sums "
          "over the motions\n"};
}

}  // namespace volccd
