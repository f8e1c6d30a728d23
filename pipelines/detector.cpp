#include <volccd/pipelines/detector.hpp>

#include <algorithm>
#include <limits>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/mesh/check_element.hpp>
#include <volccd/mesh/thickened_shells.hpp>

namespace volccd {

namespace {

/// The slots of the elements that an edit removes.
std::vector<Index> removed_slots(const Mesh& mesh, std::span<const std::int64_t> ids) {
  std::vector<Index> slots;
  slots.reserve(ids.size());
  for (std::size_t i = 0; i < ids.size(); ++i) {
    slots.push_back(mesh.find_element(ids[i]));
    if (slots.back() == kNone)
      throw InputError("edit", "removed", static_cast<std::int64_t>(i), fmt::format("there is no element {}", ids[i]));
  }
  if (const std::size_t i = detail::find_repeated<Index>(slots); i < slots.size())
    throw InputError("edit", "removed", static_cast<std::int64_t>(i), fmt::format("element {} occurs twice", ids[i]));
  return slots;
}

/// The edit by slots.
TopologyEdit topology_edit(const Mesh& mesh, const DetectorEdit& edit) {
  TopologyEdit result{.removed = removed_slots(mesh, edit.removed), .added = edit.added};
  const std::int64_t last = mesh.vertex_count() == 0 ? -1 : mesh.vertex_ids().back();
  if (last > std::numeric_limits<std::int64_t>::max() - edit.new_vertices)
    throw InputError("edit", "new_vertices", "no ids are left above the last vertex");
  for (Index i = 1; i <= edit.new_vertices; ++i) result.new_vertex_ids.push_back(last + i);
  return result;
}

}  // namespace

struct Detector::State {
  State(Mesh mesh, std::optional<ThickenedShells> its_shells, const DetectorConfig& config, const Registry& registry)
      : runner(Pipeline(registry, registry.pipeline(config.pipeline, config.settings)),
               {.threads = config.threads,
                .executor = config.executor,
                .separation = config.separation,
                .filter = config.filter,
                .leave_out_shell_neighbours = its_shells.has_value(),
                .lists = config.lists}),
        shells(std::move(its_shells)),
        topology(std::move(mesh), runner.executor(), config.edge_set) {}

  const Mesh& mesh() const { return shells ? shells->mesh() : topology.mesh(); }

  /// Motion checks that positions are finite, but with shells it gets those of the solid mesh.
  void check_positions(std::span<const Vec3> x, const char* array) const {
    if (x.size() != mesh().vertex_count())
      throw InputError("motion", array, fmt::format("{} positions for {} vertices", x.size(), mesh().vertex_count()));
    if (!shells) return;
    const auto found = std::ranges::find_if(x, [](const Vec3& p) { return !p.allFinite(); });
    if (found != x.end()) throw InputError("motion", array, found - x.begin(), "not a finite position");
  }

  /// Control points at both ends for thickened shells.
  void set_ends(std::span<const Vec3> x0, std::span<const Vec3> x1) {
    shells->positions(x0, solid0, runner.executor());
    shells->positions(x1, solid1, runner.executor());
  }

  StepRunner runner;
  std::optional<ThickenedShells> shells;
  Topology topology;
  Motion motion;
  std::vector<Vec3> solid0, solid_middle, solid1;  ///< control points of the solid mesh
};

Detector::Detector(Mesh mesh, const DetectorConfig& config, const Registry& registry)
    : state_(std::make_unique<State>(std::move(mesh), std::nullopt, config, registry)) {}

Detector::Detector(Mesh mesh, std::span<const double> thickness, const DetectorConfig& config,
                   const Registry& registry) {
  ThickenedShells shells(std::move(mesh), {thickness.begin(), thickness.end()});
  Mesh solids = shells.solid_mesh();
  state_ = std::make_unique<State>(std::move(solids), std::move(shells), config, registry);
}

Detector::~Detector() = default;
Detector::Detector(Detector&&) noexcept = default;
Detector& Detector::operator=(Detector&&) noexcept = default;

const StepResult& Detector::step(std::span<const Vec3> x0, std::span<const Vec3> x1, const Request& request,
                                 double t_max) {
  State& s = *state_;
  s.check_positions(x0, "x0");
  s.check_positions(x1, "x1");
  if (s.shells) {
    s.set_ends(x0, x1);
    s.motion.set_linear(s.solid0, s.solid1);
  } else {
    s.motion.set_linear(x0, x1);
  }
  return step(s.motion, request, t_max);
}

const StepResult& Detector::step(std::span<const Vec3> x0, std::span<const Vec3> xm, std::span<const Vec3> x1,
                                 const Request& request, double t_max) {
  State& s = *state_;
  s.check_positions(x0, "x0");
  s.check_positions(xm, "xm");
  s.check_positions(x1, "x1");
  if (s.shells) {
    s.set_ends(x0, x1);
    solid_middle_points(x0, xm, x1, s.solid0, s.solid1, s.solid_middle);
    s.motion.set_quadratic(s.solid0, s.solid_middle, s.solid1);
  } else {
    s.motion.set_quadratic(x0, xm, x1);
  }
  return step(s.motion, request, t_max);
}

const StepResult& Detector::step(const Motion& motion, const Request& request, double t_max) {
  return state_->runner.run(state_->topology, motion, request, t_max);
}

std::optional<Contact> Detector::first(std::span<const Vec3> x0, std::span<const Vec3> x1) {
  const StepResult& found = step(x0, x1, {.query = Query::first});
  if (found.contacts.empty()) return std::nullopt;
  return found.contacts.front();
}

void Detector::edit(const DetectorEdit& edit) {
  State& s = *state_;
  const TopologyEdit by_slot = topology_edit(s.mesh(), edit);
  const std::size_t expected = s.shells ? edit.added.size() : 0;
  if (edit.thickness.size() != expected)
    throw InputError("edit", "thickness", fmt::format("{} values, not {}", edit.thickness.size(), expected));
  if (!s.shells) {
    s.topology.apply(by_slot);
    return;
  }
  // Both calls that may fail are before the first change, or change nothing if they fail.
  static_assert(std::is_nothrow_move_assignable_v<ThickenedShells>);
  ThickenedShells edited = s.shells->edited(by_slot, edit.thickness);
  s.topology.apply(edited.edit_of_solids(s.topology.mesh()));
  s.shells = std::move(edited);
}

const Mesh& Detector::mesh() const { return state_->mesh(); }
const Topology& Detector::topology() const { return state_->topology; }
bool Detector::thickens_shells() const { return state_->shells.has_value(); }
const StepResult& Detector::result() const { return state_->runner.result(); }
StepResult Detector::release_result() { return state_->runner.release_result(); }
const Pipeline& Detector::pipeline() const { return state_->runner.pipeline(); }
Executor& Detector::executor() const { return state_->runner.executor(); }
double Detector::separation() const { return state_->runner.separation(); }
void Detector::set_separation(double separation) { state_->runner.set_separation(separation); }
std::size_t Detector::workspace_bytes() const { return state_->runner.workspace_bytes(); }

}  // namespace volccd
