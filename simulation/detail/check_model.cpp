#include <volccd/simulation/detail/check_model.hpp>

#include <algorithm>
#include <cmath>

#include <volccd/core/error.hpp>

namespace volccd::simulation::detail {
namespace {

void check(bool good, const char* dataset, std::size_t index, const char* problem) {
  if (!good) throw InputError("model", dataset, static_cast<std::int64_t>(index), problem);
}

void check_guide(const Model& model, std::size_t i) {
  const Guide& guide = model.guides[i];
  const auto object = static_cast<std::size_t>(guide.object);
  check(guide.object >= 0 && object < model.bodies.size() && model.bodies[object].rigid, "guides", i,
        "is of no rigid body");
  check(!guide.path.empty(), "guides", i, "has no points");
  for (std::size_t k = 0; k < guide.path.size(); ++k) {
    const auto& [time, displacement] = guide.path[k];
    check(std::isfinite(time) && displacement.allFinite(), "guides", i, "has a point that is not finite");
    check(k == 0 || time > guide.path[k - 1].first, "guides", i, "has times that do not ascend");
  }
  check(guide.displacement(0).isZero(0), "guides", i, "has a displacement at time 0");
  for (std::size_t k = 0; k < i; ++k)
    check(model.guides[k].object != guide.object, "guides", i, "is of a body that has a guide already");
  for (Index o = 0; o < model.mesh.element_slots(); ++o)
    if (model.mesh.is_live(o) && model.mesh.object(o) == guide.object)
      for (const Index v : model.mesh.vertices(o))
        check(std::ranges::find(model.fixed, v) == model.fixed.end(), "guides", i, "is of a body with a fixed vertex");
}

}  // namespace

void check_model(const Model& model) {
  const Index vertices = model.mesh.vertex_count();
  check(model.positions.size() == vertices, "positions", model.positions.size(), "is not the number of vertices");
  check(model.velocities.size() == vertices, "velocities", model.velocities.size(), "is not the number of vertices");
  for (std::size_t v = 0; v < vertices; ++v) {
    check(model.positions[v].allFinite(), "positions", v, "is not finite");
    check(model.velocities[v].allFinite(), "velocities", v, "is not finite");
  }
  const auto is_body = [&](std::int32_t object) {
    return object >= 0 && static_cast<std::size_t>(object) < model.bodies.size();
  };
  for (Index o = 0; o < model.mesh.element_slots(); ++o)
    check(!model.mesh.is_live(o) || is_body(model.mesh.object(o)), "mesh", o, "is of an object without a body");
  for (std::size_t i = 0; i < model.fixed.size(); ++i) check(model.fixed[i] < vertices, "fixed", i, "is no vertex");
  for (std::size_t i = 0; i < model.walls.size(); ++i)
    check(std::abs(model.walls[i].normal.norm() - 1) < 1e-9, "walls", i, "has a normal of another length than 1");
  for (std::size_t i = 0; i < model.cuts.size(); ++i) check(is_body(model.cuts[i].object), "cuts", i, "is of no body");
  check(model.gravity.allFinite(), "gravity", 0, "is not finite");
  for (std::size_t i = 0; i < model.guides.size(); ++i) check_guide(model, i);
}

void check_options(const SimulationOptions& options) {
  if (!(options.step_safety > 0 && options.step_safety <= 1)) throw ConfigError("step_safety must be in (0, 1]");
  if (!(options.max_step > 0)) throw ConfigError("max_step must be above 0");
  if (options.contact_passes < 1 || options.contact_iterations < 1)
    throw ConfigError("contact_passes and contact_iterations must be 1 or more");
  if (options.topology_interval < 1) throw ConfigError("topology_interval must be 1 or more");
}

}  // namespace volccd::simulation::detail
