#include <volccd/experiments/tables/feature_sets.hpp>

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <unordered_map>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/experiments/harness/corner_volumes.hpp>
#include <volccd/experiments/scenes/simulated/bake.hpp>
#include <volccd/experiments/tables/rows.hpp>
#include <volccd/io/sequence/stepper.hpp>
#include <volccd/io/stats_json.hpp>
#include <volccd/pipelines/step_runner.hpp>
#include <volccd/simulation/contact/contact_surface.hpp>

namespace volccd {

using nlohmann::json;

namespace {

/// Six times the volume of the tetrahedron at each corner of an element.
struct CornerVolumes {
  std::array<double, 8> at;
  std::size_t count;

  double min() const { return *std::min_element(at.begin(), at.begin() + static_cast<std::ptrdiff_t>(count)); }
  /// The volume of the element: exact for a parallelepiped, where all corner volumes are equal, and for half of one.
  double volume() const {
    return std::accumulate(at.begin(), at.begin() + static_cast<std::ptrdiff_t>(count), 0.0) / (count == 8 ? 8 : 12);
  }
};

/// The corner volumes of a hexahedron or wedge in VTK's order.
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
        runner_(Pipeline(Registry::standard(), Registry::standard().pipeline("VolCCD+")), {.executor = &executor}) {
    SequenceCells cells;
    reader.read_cells(0, cells);
    reader.read_points(0, points_);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      check_type(cells.types[i], i);
      mass_[key(cells.ids[i], cells.types[i])] = corner_volumes(cells.vertices(i), points_).volume();
      striker_ = std::min(striker_, cells.objects[i]);
    }
  }

  json observe_step(int k) {
    stepper_.go_to(k, executor_);
    const Mesh& mesh = stepper_.topology().mesh();
    runner_.run(stepper_.topology(), stepper_.motion(), {.initial_overlaps = true});
    json row = {{"step", k},
                {"elements", mesh.element_count()},
                {"time", reader_.time(k + 1)},
                {"contacts", runner_.result().contacts.size()},
                {"interior", interior_contacts()}};
    row.update(overlaps(mesh));
    row.update(pieces(mesh));
    reader_.read_points(k, points_);
    const Vec3 from = centre(mesh);
    reader_.read_points(k + 1, points_);
    const Vec3 step = centre(mesh) - from;
    if (k == 0) direction_ = step.norm() > 0 ? Vec3(step.normalized()) : Vec3(Vec3::UnitZ());
    travel_ += step.dot(direction_);
    row["velocity"] = step.dot(direction_) / (reader_.time(k + 1) - reader_.time(k));
    row["travel"] = travel_;
    row["inverted"] = inverted(mesh);
    return row;
  }

  int steps() const { return stepper_.step_count(); }

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
    const simulation::ContactSurface boundary(stepper_.topology(), simulation::ContactFeatures::boundary, 1);
    return static_cast<std::size_t>(std::ranges::count_if(runner_.result().contacts, [&](const Contact& c) {
      const auto& v = c.vertices;
      if (c.kind == FeatureKind::vf)
        return !boundary.has_vertex(v[0]) || !boundary.has_triangle(features.find_triangle(v[1], v[2], v[3]));
      return !boundary.has_edge(features.find_edge(v[0], v[1])) || !boundary.has_edge(features.find_edge(v[2], v[3]));
    }));
  }

  json overlaps(const Mesh& mesh) const {
    const std::vector<ElementPair>& pairs = runner_.result().initial_overlaps;
    std::size_t inter = 0;
    for (const ElementPair& pair : pairs) inter += mesh.object(pair.a) != mesh.object(pair.b) ? 1 : 0;
    return {{"overlaps_inter", inter}, {"overlaps_intra", pairs.size() - inter}};
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
    return {{"pieces_striker", distinct(of_striker)}, {"pieces_target", distinct(of_target)}};
  }

  /// The key of an element. A wedge that is a piece of a hexahedron may have its id, but is another element.
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
      if (mesh.is_live(o)) count += corner_volumes_of(mesh, o).min() <= 0 ? 1 : 0;
    return count;
  }

  SequenceReader& reader_;
  Executor& executor_;
  SequenceStepper stepper_;
  StepRunner runner_;
  std::vector<Vec3> points_;
  std::unordered_map<std::int64_t, double> mass_;  ///< by key(): the volume at the first frame that has the element
  std::int32_t striker_ = std::numeric_limits<std::int32_t>::max();
  Vec3 direction_ = Vec3::UnitZ();
  double travel_ = 0;
};

const char* variant_of(simulation::ContactFeatures features) {
  switch (features) {
    case simulation::ContactFeatures::all: return "all";
    case simulation::ContactFeatures::boundary: return "boundary";
    case simulation::ContactFeatures::surface: return "surface";
  }
  return "";
}

/// One row for each step, with what the record of the simulation says of it.
std::vector<json> rows_of(const SimulatedScene& scene, const std::string& sequence, const json& baked,
                          Executor& executor, const std::function<void()>& check) {
  std::vector<json> rows = feature_set_motions(sequence, executor, check);
  for (json& row : rows) {
    row.update({{"table", ""},
                {"scene", scene.name},
                {"motion_model", name_of(MotionModel::linear)},
                {"pipeline", "VolCCD+"},
                {"variant", variant_of(scene.options.features)},
                {"round", 0}});
    const json& frame = baked.at("frames").at(row.at("step").get<std::size_t>() + 1);
    row["splits"] = frame.at("edits").at("splits");
    row["breaks"] = frame.at("edits").at("breaks");
    row["simulation_seconds"] = frame.at("seconds");
  }
  return rows;
}

/// The bullet, and the scenes that differ from it only in which features collide.
std::vector<const SimulatedScene*> compared_scenes() {
  std::vector<const SimulatedScene*> scenes;
  for (const SimulatedScene& scene : simulated_scenes())
    if (scene.name == "bullet" || scene.variant_of == "bullet") scenes.push_back(&scene);
  return scenes;
}

std::string source_of(const SimulatedScene& scene, const PlanContext& context) {
  return scene.name + (context.full ? "" : "-quick");
}

std::string whole(double value) { return grouped(static_cast<std::uint64_t>(value)); }

std::vector<std::string> table_row(const Rows& rows) {
  const json& last = rows.back();
  const auto at_end = [&](const char* column) { return grouped(last.at(column).get<std::uint64_t>()); };
  return {last.at("scene"),
          at_end("elements"),
          whole(rows.sum("splits")),
          at_end("pieces_striker"),
          at_end("pieces_target"),
          fmt::format("{:.0f}", last.at("velocity").get<double>()),
          fmt::format("{:.2f}", 1e3 * last.at("travel").get<double>()),
          at_end("overlaps_inter"),
          at_end("overlaps_intra"),
          whole(rows.sum("inverted")),
          whole(rows.sum("contacts")),
          whole(rows.sum("interior")),
          duration(rows.sum("simulation_seconds"))};
}

}  // namespace

std::vector<json> feature_set_motions(const std::string& sequence, Executor& executor,
                                      const std::function<void()>& check) {
  SequenceReader reader(sequence);
  Observer observer(reader, executor);
  std::vector<json> steps;
  for (int k = 0; k < observer.steps(); ++k) {
    check();
    steps.push_back(observer.observe_step(k));
  }
  return steps;
}

ExperimentPlan feature_set_plan(const PlanContext& context) {
  ExperimentPlan plan{"feature-sets", context.full ? "full" : "quick", 1, {}};
  for (const SimulatedScene* scene : compared_scenes())
    if (const std::optional<std::string> file = context.file_of(source_of(*scene, context)))
      plan.runs.push_back({scene->name, *file});
  return plan;
}

void feature_set_rows(const PlanContext& context, RecordFile& record) {
  SerialExecutor serial;
  Executor& executor = context.executor ? *context.executor : serial;
  const std::vector<const SimulatedScene*> scenes = compared_scenes();
  for (std::size_t s = 0; s < scenes.size(); ++s) {
    const std::optional<std::string> file = context.file_of(source_of(*scenes[s], context));
    if (!file || record.has(scenes[s]->name)) continue;
    BakeSettings settings;
    settings.elements = context.full ? 0 : scenes[s]->quick_elements;
    const std::function<void()> check = [&] {
      if (context.progress) context.progress(s, scenes.size());
    };
    record.add(scenes[s]->name,
               rows_of(*scenes[s], *file, read_json_file(bake_record_file(*scenes[s], settings)), executor, check));
  }
}

std::vector<TitledTable> feature_set_tables(const json& record) {
  TextTable table({"scene", "elements", "splits", "pieces, bullet", "pieces, plate", "velocity, m/s", "travel, mm",
                   "overlaps, inter", "overlaps, intra", "inverted", "contacts", "interior contacts", "computed in"});
  const Rows rows(record);
  for (const json& scene : rows.values("scene")) table.add(table_row(rows.with("scene", scene)));
  return {{"Figure 3: the bullet with contacts among all features, the boundary's, and the first surface's", table,
           "elements, pieces, velocity and travel of the bullet's centre, pairs of elements that overlap (exact; not "
           "adjacent ones): at the end; inverted elements, contacts among all features, and those with a feature "
           "inside: sums over the steps\n"}};
}

}  // namespace volccd
