#include <volccd/simulation/contact/contact_detection.hpp>

#include <algorithm>
#include <cmath>

#include <volccd/core/error.hpp>

namespace volccd::simulation {
namespace {

constexpr std::size_t kContactGrain = 64;

/// Contacts may be reported a thousandth of the substep early. Features that rest at the separation can need any number
/// of intervals: the search ends early for them, and `exact` decides.
Pipeline make_pipeline(const std::string& name) {
  const Registry registry = Registry::standard();
  PipelineSpec spec = registry.pipeline(name);
  spec.narrow_phase = {"inclusion", {{"time_tolerance", "1e-3"}, {"max_intervals", "40"}, {"undecided", "exact"}}};
  return Pipeline(registry, spec);
}

ObjectFilter filter_of(const ContactDetection::Config& config) {
  ObjectFilter filter;
  for (const auto& [a, b] : config.excluded) filter.exclude(a, b);
  return filter;
}

bool has_shells(const Mesh& mesh) {
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.is_live(o) && is_shell(mesh.type(o))) return true;
  return false;
}

bool same(const ElementSpec& spec, const Mesh& mesh, Index o) {
  const std::span<const Index> vertices = mesh.vertices(o);
  return spec.type == mesh.type(o) && std::equal(vertices.begin(), vertices.end(), spec.vertices.begin());
}

}  // namespace

ContactDetection::ContactDetection(const Topology& model, std::span<const double> thickness,
                                   std::span<const Vec3> reference, Config config, Executor& executor)
    : model_(model),
      thickness_(thickness.begin(), thickness.end()),
      reference_(reference.begin(), reference.end()),
      config_(std::move(config)),
      runner_(make_pipeline(config_.pipeline), {.executor = &executor,
                                                .filter = filter_of(config_),
                                                .leave_out_shell_neighbours = has_shells(model.mesh()),
                                                .lists = config_.lists}) {
  if (has_shells(model.mesh())) {
    thickener_.emplace(model.mesh());
    solid_ = std::make_unique<Topology>(thickener_->solid_mesh(model.mesh()), executor);
    // Otherwise edits would not have the same slots in both meshes.
    if (solid_->mesh().element_slots() != model.mesh().element_slots())
      throw InputError("model", "mesh", "a mesh with shells has empty element slots");
  }
  surface_.emplace(collision_topology(), config_.features, copies());
}

ContactDetection::~ContactDetection() = default;

void ContactDetection::follow(const TopologyEdit& edit, std::span<const double> thickness,
                              std::span<const Vec3> reference, std::span<const Index> origins) {
  thickness_.assign(thickness.begin(), thickness.end());
  reference_.assign(reference.begin(), reference.end());
  placed0_.from.clear();
  placed1_.from.clear();
  if (thickener_) {
    const Mesh& mesh = model_.mesh();
    thickener_.emplace(mesh);
    TopologyEdit solids;
    solids.new_vertex_ids = solid_vertex_ids(edit.new_vertex_ids);
    solids.removed = edit.removed;
    for (const ElementSpec& added : edit.added)
      solids.added.push_back(thickener_->solid_element(mesh, mesh.find_element(added.id)));
    solid_->apply(solids);
    // The edit may have changed the orientation of sheets: their other prisms are replaced, each in its own slot.
    for (Index o = 0; o < mesh.element_slots(); ++o) {
      if (!mesh.is_live(o) || !is_shell(mesh.type(o))) continue;
      ElementSpec spec = thickener_->solid_element(mesh, o);
      if (!same(spec, solid_->mesh(), o)) solid_->apply({.removed = {o}, .added = {std::move(spec)}});
    }
  }
  surface_->update(collision_topology(), origins);
}

const std::vector<Vec3>& ContactDetection::place(std::span<const Vec3> x, Placed& placed) {
  if (!std::equal(x.begin(), x.end(), placed.from.begin(), placed.from.end())) {
    thickener_->positions(x, thickness_, placed.to, scratch_, runner_.executor());
    placed.from.assign(x.begin(), x.end());
  }
  return placed.to;
}

/// A substep begins at the end of the one before it, and is asked about several times with different ends.
void ContactDetection::set_motion(std::span<const Vec3> x0, std::span<const Vec3> x1) {
  if (!thickener_) return motion_.set_linear(x0, x1);
  if (std::equal(x0.begin(), x0.end(), placed1_.from.begin(), placed1_.from.end())) std::swap(placed0_, placed1_);
  motion_.set_linear(place(x0, placed0_), place(x1, placed1_));
}

void ContactDetection::find(std::span<const Vec3> x0, std::span<const Vec3> x1, std::vector<FoundContact>& found) {
  set_motion(x0, x1);
  run(config_.separation, {}, found);
}

void ContactDetection::run(double separation, Request request, std::vector<FoundContact>& found) {
  request.count_adjacent = false;
  runner_.set_separation(separation);
  const std::vector<Contact>& contacts = runner_.run(collision_topology(), motion_, request).contacts;
  found.resize(contacts.size());
  if (contacts.empty()) return;
  find_middles();
  const ContactJudge judge(
      {collision_topology(), motion_, *surface_, reference_, middles_, copies(), config_.adjacent, config_.separation});
  runner_.executor().parallel_for(found.size(), kContactGrain, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t i = begin; i < end; ++i) found[i] = judge.describe(contacts[i]);
  });
}

void ContactDetection::keep_touching(std::vector<FoundContact>& found) {
  near_.clear();
  for (const FoundContact& c : found) {
    if (c.verdict != ContactVerdict::resist) continue;
    // The distance decreases at most by the remaining motion of a vertex of one feature relative to one of the other.
    const std::size_t first = c.kind == FeatureKind::vf ? 1 : 2;
    double max = 0;
    for (std::size_t i = 0; i < first; ++i)
      for (std::size_t j = first; j < 4; ++j)
        max = std::max(max, (motion_.point(c.features[i], 1) - motion_.point(c.features[i], 0) -
                             motion_.point(c.features[j], 1) + motion_.point(c.features[j], 0))
                                .norm());
    const double apart = c.at_start ? std::abs(c.gap0) : config_.separation;
    if ((1 - c.toi + 1e-3) * max >= apart * (1 - 1e-3))
      c.kind == FeatureKind::vf ? near_.vf.push_back(c.slots)
                                : near_.ee.push_back({std::min(c.slots.a, c.slots.b), std::max(c.slots.a, c.slots.b)});
  }
  found.clear();
  if (near_.size() > 0) run(0, {.tests = &near_}, found);
  std::erase_if(found, [](const FoundContact& c) { return c.verdict != ContactVerdict::resist || c.at_start; });
}

void ContactDetection::find_middles() {
  const Mesh& mesh = collision_topology().mesh();
  std::vector<double> count;
  middles_.clear();
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (!mesh.is_live(o)) continue;
    const auto object = static_cast<std::size_t>(mesh.object(o));
    if (object >= count.size()) {
      count.resize(object + 1, 0);
      middles_.resize(object + 1, Vec3::Zero());
    }
    for (Index v : mesh.vertices(o)) middles_[object] += motion_.point(v, 0);
    count[object] += static_cast<double>(mesh.vertices(o).size());
  }
  for (std::size_t i = 0; i < count.size(); ++i)
    if (count[i] > 0) middles_[i] /= count[i];
}

}  // namespace volccd::simulation
