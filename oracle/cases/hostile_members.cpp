// Fixed cases, their reduction, and their text.
#include <algorithm>

#include <fmt/format.h>

#include <volccd/oracle/cases/hostile_parts.hpp>

namespace volccd::cases {
namespace {

HostileStep linear_step(const std::vector<Vec3>& x0, const std::vector<Vec3>& x1, std::size_t mesh = 0) {
  HostileStep step;
  step.mesh = mesh;
  step.motion = Motion::linear(x0, x1);
  return step;
}

HostileMesh family_member(const char* family, Choices& c) {
  for (const HostileFamily& one : hostile_families())
    if (std::string(one.name) == family) return one.make(c);
  return {};
}

/// A star whose link has a handle covers directions twice, although it is a manifold with a closed ring.
HostileCase star_that_covers_directions_twice() {
  const std::vector<std::uint32_t> none;
  Choices zeros(none);
  HostileMesh star = family_member("StarWithHandle", zeros);
  append_calm_block(star, 10);
  HostileCase made{"StarThatCoversDirectionsTwice", {star.shape.mesh()}, {}};
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Choices c(seed);
    std::vector<Vec3> end = star.shape.positions;
    for (Index v = 0; v < star.moving; ++v) end[v] += lattice_point(c, 12);
    made.steps.push_back(linear_step(star.shape.positions, end));
  }
  return made;
}

/// Two triangles that are pinned to a body at an interior vertex pass through the body, away from that vertex.
HostileCase strip_pinned_inside_a_body() {
  constexpr int kLattice = 6;
  HostileMesh body = tetrahedron_block(5, 5, 5, 128);
  constexpr Index kPin = (2 * kLattice + 2) * kLattice + 2;
  std::vector<Vec3> x = body.shape.positions;
  for (const Vec3& p : {Vec3(440, 241, 257), Vec3(422, 292, 310), Vec3(456, 340, 281)}) x.push_back(p);
  std::vector<Vec3> end = x;
  end[216] = Vec3(454, 228, 230), end[217] = Vec3(444, 284, 319), end[218] = Vec3(504, 338, 311);
  body.shape.positions = x;
  add_element(body.shape.elements, ElementType::triangle, {kPin, 216, 217});
  add_element(body.shape.elements, ElementType::triangle, {216, 217, 218});
  return {"StripPinnedInsideABody", {body.shape.mesh()}, {linear_step(x, end)}};
}

/// A small mesh, a large one for which the flood declines the step (initial overlaps of pyramids), and the small one
/// again, in one workspace. The parts of all elements on the boundary are whole elements, so that the subset of
/// boundary parts does not change from the large mesh to the small one.
HostileCase topologies_in_turn() {
  Shape small;
  small.positions = {{0, 0, 0}, {16, 0, 0}, {0, 16, 0}, {0, 0, 16}, {16, 16, 16}};
  add_element(small.elements, ElementType::tetrahedron, {0, 1, 2, 3});
  add_element(small.elements, ElementType::tetrahedron, {1, 2, 3, 4});
  const Shape large = apart(ElementType::pyramid, 400).shape;
  HostileCase made{"TopologiesInTurn", {small.mesh(), large.mesh()}, {}};
  for (const std::size_t which : {0, 1, 0, 1, 1, 0}) {
    const std::vector<Vec3>& x = (which ? large : small).positions;
    std::vector<Vec3> end = x;
    end[1] += Vec3(-40, 3, 5);
    HostileStep step = linear_step(x, end, which);
    step.initial_overlaps = which == 1;
    made.steps.push_back(std::move(step));
  }
  return made;
}

constexpr HostileMember kMembers[] = {{"StarThatCoversDirectionsTwice", star_that_covers_directions_twice},
                                      {"StripPinnedInsideABody", strip_pinned_inside_a_body},
                                      {"TopologiesInTurn", topologies_in_turn}};

Mesh without_element(const Mesh& mesh, const std::vector<std::int64_t>& ids) {
  Mesh result;
  result.add_vertices(mesh.vertex_ids());
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.is_live(o) && std::find(ids.begin(), ids.end(), mesh.element_id(o)) == ids.end())
      result.add_element(mesh.spec(o));
  return result;
}

/// The case without these elements of one of its meshes; edits that remove them no longer do.
HostileCase without_elements(HostileCase c, std::size_t mesh, const std::vector<std::int64_t>& ids) {
  c.meshes[mesh] = without_element(c.meshes[mesh], ids);
  const auto gone = [&](std::int64_t id) { return std::find(ids.begin(), ids.end(), id) != ids.end(); };
  for (HostileStep& step : c.steps)
    if (step.mesh == mesh) std::erase_if(step.removed, gone);
  return c;
}

std::vector<std::int64_t> element_ids(const Mesh& mesh) {
  std::vector<std::int64_t> ids;
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.is_live(o)) ids.push_back(mesh.element_id(o));
  return ids;
}

using Fails = std::function<bool(const HostileCase&)>;

/// Steps with edits stay, because later ones depend on them.
void reduce_steps(HostileCase& c, const Fails& fails) {
  for (std::size_t i = c.steps.size(); i-- > 0;) {
    HostileCase less = c;
    less.steps.erase(less.steps.begin() + static_cast<std::ptrdiff_t>(i));
    const HostileStep& step = c.steps[i];
    const bool last = i + 1 == c.steps.size();
    const bool edit = !step.removed.empty() || !step.added.empty() || step.new_vertices > 0;
    if ((last || !edit) && fails(less)) c = std::move(less);
  }
}

/// Returns whether elements were left out.
bool reduce_elements(HostileCase& c, const Fails& fails) {
  bool any = false;
  for (std::size_t mesh = 0; mesh < c.meshes.size(); ++mesh)
    for (std::size_t chunk = (element_ids(c.meshes[mesh]).size() + 1) / 2; chunk > 0; chunk /= 2) {
      const std::vector<std::int64_t> ids = element_ids(c.meshes[mesh]);
      for (std::size_t begin = 0; begin < ids.size(); begin += chunk) {
        const auto end = ids.begin() + static_cast<std::ptrdiff_t>(std::min(ids.size(), begin + chunk));
        HostileCase less = without_elements(c, mesh, {ids.begin() + static_cast<std::ptrdiff_t>(begin), end});
        if (less.meshes[mesh].element_count() == 0 || !fails(less)) continue;
        c = std::move(less);
        any = true;
      }
    }
  return any;
}

/// Sets properties of the steps to their defaults.
void reduce_properties(HostileCase& c, const Fails& fails) {
  for (std::size_t i = 0; i < c.steps.size(); ++i) {
    const auto attempt = [&](auto&& change) {
      HostileCase less = c;
      change(less.steps[i]);
      if (fails(less)) c = std::move(less);
    };
    attempt([](HostileStep& step) { step.separation = 0; });
    attempt([](HostileStep& step) { step.t_max = 1; });
    attempt([](HostileStep& step) { step.filter = {}; });
    attempt([](HostileStep& step) { step.initial_overlaps = step.first_only = false; });
    const Index vertices = c.steps[i].motion.vertex_count();
    for (Index first = 0, count = vertices; count > 0;
         first + count < vertices ? first += count : (first = 0, count /= 4))
      attempt([&](HostileStep& step) {  // these vertices stand still
        for (Index v = first; v < std::min(vertices, first + count); ++v)
          for (int k = 1; k < step.motion.control_points(); ++k) step.motion.set(v, k, step.motion.point(v, 0));
      });
  }
}

std::string text_of(const ElementSpec& e) {
  return fmt::format("{} {} ({}) object {}", e.id, to_string(e.type), fmt::join(e.vertices, " "), e.object);
}

}  // namespace

std::span<const HostileMember> hostile_members() { return kMembers; }

HostileCase reduced(HostileCase c, const std::function<bool(const HostileCase&)>& fails) {
  reduce_steps(c, fails);
  while (reduce_elements(c, fails)) {
  }
  reduce_properties(c, fails);
  while (reduce_elements(c, fails)) {
  }
  return c;
}

std::string to_text(const HostileCase& c) {
  std::string text = c.name + "\n";
  std::vector<bool> used;
  const auto use = [&](const ElementSpec& e) {
    for (const Index v : e.vertices) {
      if (v >= used.size()) used.resize(v + 1, false);
      used[v] = true;
    }
    return text_of(e);
  };
  for (const Mesh& mesh : c.meshes) {
    text += "mesh\n";
    for (Index o = 0; o < mesh.element_slots(); ++o)
      if (mesh.is_live(o)) text += "  " + use(mesh.spec(o)) + "\n";
  }
  for (const HostileStep& step : c.steps) {
    text += fmt::format("step of mesh {}: {}; separation {}, t_max {}{}{}{}\n", step.mesh, step.what, step.separation,
                        step.t_max, step.filter.trivial() ? "" : ", with an object filter",
                        step.first_only ? ", first contact only" : "",
                        step.initial_overlaps ? ", with initial overlaps" : "");
    if (!step.removed.empty()) text += fmt::format("  removed {}\n", fmt::join(step.removed, " "));
    for (const ElementSpec& e : step.added) text += "  added " + use(e) + "\n";
    for (Index v = 0; v < step.motion.vertex_count(); ++v) {
      if (v >= used.size() || !used[v]) continue;
      text += fmt::format("  vertex {}:", v);
      for (int k = 0; k < step.motion.control_points(); ++k) {
        const Vec3 p = step.motion.point(v, k);
        text += fmt::format("{} ({}, {}, {})", k ? " ->" : "", p.x(), p.y(), p.z());
      }
      text += "\n";
    }
  }
  return text;
}

}  // namespace volccd::cases
