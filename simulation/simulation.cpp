#include <volccd/simulation/simulation.hpp>

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <volccd/core/error.hpp>
#include <volccd/simulation/contact_response.hpp>
#include <volccd/simulation/element_breaking.hpp>
#include <volccd/simulation/element_cutting.hpp>
#include <volccd/simulation/node_merging.hpp>
#include <volccd/simulation/node_splitting.hpp>
#include <volccd/simulation/pressure_forces.hpp>
#include <volccd/simulation/rigid_bodies.hpp>
#include <volccd/simulation/shell_forces.hpp>
#include <volccd/simulation/solid_forces.hpp>

namespace volccd::simulation {
namespace {

/// Default separation, as a fraction of the shortest edge, and greatest one, of the thickness of the thinnest shell.
constexpr double kSeparationOfEdge = 0.01, kSeparationOfThickness = 0.1;
/// Bounds of the margin of queries, in units of the default separation. The upper bound applies if there are no prisms,
/// whose opposite sides are near each other.
constexpr double kLeastMargin = 4, kMostMargin = 15;
/// Distance that a blade moves between two cuts, in mean edges of the part.
constexpr double kCutAdvance = 0.25;

void check(bool good, const char* dataset, std::size_t index, const char* problem) {
  if (!good) throw InputError("model", dataset, static_cast<std::int64_t>(index), problem);
}

void check_guide(const Model& model, std::size_t i) {
  const Guide& guide = model.guides[i];
  const auto object = static_cast<std::size_t>(guide.object);
  check(guide.object >= 0 && object < model.parts.size() && model.parts[object].rigid, "guides", i,
        "is of no rigid part");
  check(!guide.path.empty(), "guides", i, "has no points");
  for (std::size_t k = 0; k < guide.path.size(); ++k) {
    const auto& [time, displacement] = guide.path[k];
    check(std::isfinite(time) && displacement.allFinite(), "guides", i, "has a point that is not finite");
    check(k == 0 || time > guide.path[k - 1].first, "guides", i, "has times that do not ascend");
  }
  check(guide.displacement(0).isZero(0), "guides", i, "has a displacement at time 0");
  for (std::size_t k = 0; k < i; ++k)
    check(model.guides[k].object != guide.object, "guides", i, "is of a part that has a guide already");
  for (Index o = 0; o < model.mesh.element_slots(); ++o)
    if (model.mesh.is_live(o) && model.mesh.object(o) == guide.object)
      for (const Index v : model.mesh.vertices(o))
        check(std::ranges::find(model.fixed, v) == model.fixed.end(), "guides", i, "is of a part with a fixed vertex");
}

void check_model(const Model& model) {
  const Index vertices = model.mesh.vertex_count();
  check(model.positions.size() == vertices, "positions", model.positions.size(), "is not the number of vertices");
  check(model.velocities.size() == vertices, "velocities", model.velocities.size(), "is not the number of vertices");
  for (std::size_t v = 0; v < vertices; ++v) {
    check(model.positions[v].allFinite(), "positions", v, "is not finite");
    check(model.velocities[v].allFinite(), "velocities", v, "is not finite");
  }
  const auto is_part = [&](std::int32_t object) {
    return object >= 0 && static_cast<std::size_t>(object) < model.parts.size();
  };
  for (Index o = 0; o < model.mesh.element_slots(); ++o)
    check(!model.mesh.is_live(o) || is_part(model.mesh.object(o)), "mesh", o, "is of an object that is no part");
  for (std::size_t i = 0; i < model.fixed.size(); ++i) check(model.fixed[i] < vertices, "fixed", i, "is no vertex");
  for (std::size_t i = 0; i < model.walls.size(); ++i)
    check(std::abs(model.walls[i].normal.norm() - 1) < 1e-9, "walls", i, "has a normal of another length than 1");
  for (std::size_t i = 0; i < model.cuts.size(); ++i) check(is_part(model.cuts[i].object), "cuts", i, "is of no part");
  check(model.gravity.allFinite(), "gravity", 0, "is not finite");
  for (std::size_t i = 0; i < model.guides.size(); ++i) check_guide(model, i);
}

void check_options(const SimulationOptions& options) {
  if (!(options.step_safety > 0 && options.step_safety <= 1)) throw ConfigError("step_safety must be in (0, 1]");
  if (!(options.max_step > 0)) throw ConfigError("max_step must be above 0");
  if (options.substeps_per_query < 1) throw ConfigError("substeps_per_query must be 1 or more");
  if (options.contact_passes < 1 || options.contact_iterations < 1)
    throw ConfigError("contact_passes and contact_iterations must be 1 or more");
  if (options.topology_interval < 1) throw ConfigError("topology_interval must be 1 or more");
}

template <class Visitor>
void visit_edges(const Topology& topology, Visitor&& visitor) {
  const Features& features = topology.features();
  for (Index e = 0; e < features.edge_slots(); ++e)
    if (!features.edge_elements(e).empty()) visitor(features.edge(e), features.edge_elements(e)[0]);
}

template <class T>
void archive_plain(Archive& archive, T& value) {
  std::vector<T> one = {value};
  archive(one);
  if (one.size() != 1) throw InputError("checkpoint", "", "damaged");
  value = one[0];
}

void archive_spec(Archive& archive, ElementSpec& spec) {
  archive(spec.type);
  archive(spec.vertices);
  archive(spec.faces);
  archive(spec.object);
  archive(spec.id);
}

void archive_proposal(Archive& archive, TopologyProposal& proposal) {
  archive(proposal.edit.removed);
  archive(proposal.edit.new_vertex_ids);
  std::uint64_t added = proposal.edit.added.size();
  archive(added);
  proposal.edit.added.resize(static_cast<std::size_t>(added));
  for (ElementSpec& spec : proposal.edit.added) archive_spec(archive, spec);
  archive(proposal.new_vertices);
  archive(proposal.parents);
  archive(proposal.moved);
  archive(proposal.shapes_of_parents);
}

}  // namespace

struct Simulation::State {
  State(Model m, SimulationOptions o, Executor& e);

  // Preparation.
  double choose_separation();
  void make_detection();
  void renew_masses();
  std::vector<double> thickness() const;

  // A substep.
  double next_step(double until, bool& last) const;
  void substep(double dt, bool query);
  void kick(double dt);
  void damp_bodies(double dt);
  void collide(double dt, bool query);
  void hinder(std::span<const Vec3> velocity, std::span<const Vec3> x0, std::span<const Vec3> end, double dt);
  void evaluate_forces(double dt);
  void account();

  // Topology.
  void change_topology();
  bool cut();
  bool merge(double dt);
  bool break_and_split();
  void apply(TopologyProposal proposal);
  void edit(const TopologyProposal& proposal);
  void replay(std::vector<TopologyProposal> edits);

  Model model;  ///< its mesh is as at the start
  SimulationOptions options;
  Executor& executor;
  std::optional<Topology> topology;
  std::unique_ptr<ElementForces> solids, shells;
  PressureForces pressure;
  std::optional<RigidBodies> bodies;
  std::unique_ptr<ContactResponse> contacts;

  // State that changes from step to step.
  double time = 0, last_dt = 0;
  std::vector<Vec3> x, v, reference, start;
  std::vector<Vec3> outer, force;  ///< external; all
  std::vector<char> fixed;
  Ledger ledger;
  SimulationCounts counts;
  std::vector<double> depth;  ///< to which each cut has been made
  std::uint64_t since_edit = 0;
  std::vector<TopologyProposal> edits;
  std::vector<Vec3> since;                   ///< positions at the last query
  double elapsed = 0;                        ///< time since the last query
  std::vector<Vec3> asked_start, asked_end;  ///< of the last query
  double asked_separation = 0;

  // Data that follow from this state.
  std::vector<double> mass, inverse_mass, damping;
  std::vector<Index> part_of;
  std::vector<double> cut_advance;
  std::vector<Index> origins;  ///< by vertex: the vertex of the initial mesh of which it is a copy, or itself
  bool may_split = false, may_merge = false;
  std::vector<Vec3> x1;          ///< positions after a substep; then those before it
  std::vector<Vec3> unhindered;  ///< velocities before contacts
  std::vector<VertexStress> stress;
  std::vector<char> pressed;
};

Simulation::State::State(Model m, SimulationOptions o, Executor& e)
    : model((check_model(m), std::move(m))),
      options((check_options(o), std::move(o))),
      executor(e),
      topology(model.mesh),
      solids(make_solid_forces(model)),
      shells(make_shell_forces(model)),
      pressure(model),
      x(model.positions),
      v(model.velocities),
      reference(model.positions),
      start(model.positions),
      fixed(model.mesh.vertex_count(), 0),
      depth(model.cuts.size(), 0),
      since(model.positions),
      asked_start(model.positions),
      asked_end(model.positions) {
  for (Index i : model.fixed) fixed[i] = 1;
  for (Index i = 0; i < x.size(); ++i) origins.push_back(i);
  mass.resize(x.size());
  solids->add_masses(mass);
  shells->add_masses(mass);
  bodies.emplace(model, mass);
  renew_masses();
  bodies->write_velocities(v);
  bodies->mark();
  for (const Part& part : model.parts) {
    may_split |= part.material.failure_stress < kNever || part.material.failure_strain < kNever ||
                 part.material.breaking_strain < kNever;
    may_merge |= part.material.merging_force < kNever && part.material.merging_distance > 0;
  }
  for (const Cut& c : model.cuts) {
    double sum = 0, edges = 0;
    visit_edges(*topology, [&](const auto& edge, Index element) {
      if (topology->mesh().object(element) != c.object) return;
      sum += (x[edge[0]] - x[edge[1]]).norm();
      ++edges;
    });
    cut_advance.push_back(edges > 0 ? kCutAdvance * sum / edges : 0);
  }
  make_detection();
  evaluate_forces(0);
  account();
  ledger.initial = ledger.kinetic + ledger.elastic;
}

double Simulation::State::choose_separation() {
  double d = kNever;
  visit_edges(*topology, [&](const auto& edge, Index) {
    const double length = (x[edge[0]] - x[edge[1]]).norm();
    if (length > 0) d = std::min(d, kSeparationOfEdge * length);
  });
  for (double h : thickness())
    if (h > 0) d = std::min(d, kSeparationOfThickness * h);
  return d < kNever ? d : 0;
}

void Simulation::State::make_detection() {
  const double chosen = choose_separation();
  const double separation = options.separation < 0 ? chosen : options.separation;
  std::unique_ptr<ContactDetection> detection;
  if (options.contacts) {
    ContactDetection::Config config;
    config.pipeline = options.pipeline;
    config.features = options.features;
    config.adjacent = options.adjacent_contacts;
    config.excluded = options.excluded;
    for (std::size_t i = 0; i < model.parts.size(); ++i)
      if (model.parts[i].rigid)
        config.excluded.emplace_back(static_cast<std::int32_t>(i), static_cast<std::int32_t>(i));
    config.separation = separation;
    const std::vector<double> h = thickness();
    const bool prisms = std::any_of(h.begin(), h.end(), [](double t) { return t > 0; });
    config.least_margin = kLeastMargin * chosen;
    config.most_margin = (prisms ? kLeastMargin : kMostMargin) * chosen;
    detection = std::make_unique<ContactDetection>(*topology, h, reference, config);
  }
  contacts = std::make_unique<ContactResponse>(
      std::move(detection), model.parts, model.walls,
      ContactResponse::Config{options.contact_passes, options.contact_iterations, separation});
}

void Simulation::State::renew_masses() {
  mass.assign(x.size(), 0);
  solids->add_masses(mass);
  shells->add_masses(mass);
  inverse_mass.assign(x.size(), 0);
  damping.assign(x.size(), 0);
  part_of.assign(x.size(), 0);
  const Features& features = topology->features();
  for (Index i = 0; i < x.size(); ++i) {
    const auto elements = features.vertex_elements(i);
    if (!elements.empty()) part_of[i] = static_cast<Index>(topology->mesh().object(elements[0]));
    for (Index o : elements)
      damping[i] += model.parts[static_cast<std::size_t>(topology->mesh().object(o))].material.damping /
                    static_cast<double>(elements.size());
    const bool moves = mass[i] > 0 && !fixed[i] && bodies->body_of()[i] == kNone;
    if (moves) inverse_mass[i] = 1 / mass[i];
    if (!moves && bodies->body_of()[i] == kNone) v[i].setZero();
  }
}

std::vector<double> Simulation::State::thickness() const {
  const Mesh& mesh = topology->mesh();
  std::vector<double> result(mesh.element_slots(), 0);
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.is_live(o) && is_shell(mesh.type(o)))
      result[o] = model.parts[static_cast<std::size_t>(mesh.object(o))].thickness;
  return result;
}

double Simulation::State::next_step(double until, bool& last) const {
  const double most = std::min(
      {options.max_step, options.step_safety * solids->stable_step(), options.step_safety * shells->stable_step()});
  const double left = until - time;
  const double steps = std::ceil(left / most * (1 - 1e-12));
  last = !(steps > 1);
  if (!(most > 0) || time + left / std::max(steps, 1.0) == time)
    throw Error(fmt::format("simulation: the stable step is {} s at time {} s", most, time));
  return last ? left : left / steps;
}

void Simulation::State::substep(double dt, bool query) {
  bodies->follow_guides(time + dt, dt);
  kick(dt);
  unhindered = v;
  for (std::size_t i = 0; i < x.size(); ++i) x1[i] = inverse_mass[i] > 0 ? Vec3(x[i] + dt * v[i]) : x[i];
  bodies->drift(dt);
  bodies->write_vertices(x1, v);
  collide(dt, query);
  hinder(unhindered, x, x1, dt);
  std::swap(x, x1);
  time += dt;
  last_dt = dt;
  ++counts.substeps;
  ++since_edit;
}

/// Advances velocities from the middle of the last substep to the middle of the next one, over half of each.
void Simulation::State::kick(double dt) {
  const double step = (last_dt + dt) / 2;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const bool free = inverse_mass[i] > 0;
    const Index body = bodies->body_of()[i];
    const bool held = !free && (body == kNone || bodies->bodies()[body].held);
    const Vec3 before = v[i];
    if (free) {
      const double c = damping[i];
      v[i] = (v[i] + step * inverse_mass[i] * force[i]) / (1 + c * step);
      if (c > 0) {
        const Vec3 next = (before + last_dt * inverse_mass[i] * force[i]) / (1 + c * last_dt);  // as account() took it
        const Vec3 taken = step * c * mass[i] * v[i];
        ledger.damping += (taken.dot(v[i] + before) - last_dt * c * mass[i] * next.dot(before)) / 2;
        ledger.impulse -= taken;
        ledger.angular_impulse -= x[i].cross(taken);
      }
    }
    // The external force on a fixed vertex balances all forces on it.
    const Vec3 impulse = step * (held ? Vec3(outer[i] - force[i]) : outer[i]);
    ledger.impulse += impulse;
    ledger.angular_impulse += x[i].cross(impulse);
    ledger.external += (step - last_dt) / 2 * outer[i].dot(before);
  }
  bodies->kick(force, step);
  bodies->write_velocities(v);
  damp_bodies(step);
  for (std::size_t i = 0; i < x.size(); ++i) ledger.external += step / 2 * outer[i].dot(v[i]);
}

void Simulation::State::damp_bodies(double dt) {
  for (RigidBody& body : bodies->bodies()) {
    const double c = damping[body.vertices[0]];
    if (body.held || c == 0) continue;
    const Vec3 momentum = body.mass * body.velocity, spin = body.spin;
    const auto energy = [&] {
      return (body.mass * body.velocity.squaredNorm() + body.spin.dot(body.angular_velocity)) / 2;
    };
    const double before = energy();
    body.velocity /= 1 + c * dt;
    body.spin /= 1 + c * dt;
    body.angular_velocity /= 1 + c * dt;
    ledger.damping += before - energy();
    const Vec3 lost = momentum - body.mass * body.velocity;
    ledger.impulse -= lost;
    ledger.angular_impulse -= body.center.cross(lost) + spin - body.spin;
  }
  bodies->write_velocities(v);
}

void Simulation::State::collide(double dt, bool query) {
  elapsed += dt;
  ContactWork work;
  const MovingVertices moving{inverse_mass, x1, v, *bodies};
  if (query) {
    contacts->query_substep(x, since, elapsed, part_of, dt, moving, executor, work);
    if (const ContactDetection* detection = contacts->detection()) {
      asked_start = since;
      asked_end.assign(contacts->queried_end().begin(), contacts->queried_end().end());
      asked_separation = detection->queried_separation();
    }
    since = x1;
    bodies->mark();
    elapsed = 0;
  } else {
    contacts->substep(x, part_of, dt, moving, executor, work);
  }
  ledger.contact += work.total - work.friction;
  ledger.friction += work.friction;
  ledger.external += work.external;
  ledger.impulse += work.impulse;
  ledger.angular_impulse += work.angular_impulse;
}

/// The actual displacement, from x0 to `end`, is smaller than that at the velocity if contacts hinder it. The
/// difference is not work of the forces, and not energy lost in contacts, so that both are corrected here. (For a body
/// at rest, the contact removes in each substep what the forces add, and neither is work.) Called with the forces at
/// both ends.
void Simulation::State::hinder(std::span<const Vec3> velocity, std::span<const Vec3> x0, std::span<const Vec3> end,
                               double dt) {
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3 missing = dt * velocity[i] - (end[i] - x0[i]);
    ledger.external -= outer[i].dot(missing) / 2;
    ledger.contact -= force[i].dot(missing) / 2;
  }
}

void Simulation::State::evaluate_forces(double dt) {
  outer.assign(x.size(), Vec3::Zero());
  force.assign(x.size(), Vec3::Zero());
  x1.resize(x.size());
  solids->add_forces(x, v, dt, executor, force);
  shells->add_forces(x, v, dt, executor, force);
  if (!pressure.empty()) pressure.add_forces(x, v, time, executor, outer);
  for (std::size_t i = 0; i < x.size(); ++i) {
    outer[i] += mass[i] * model.gravity;
    force[i] += outer[i];
  }
  // What moves a guided body balances all forces on it, and does their work.
  for (const RigidBody& body : bodies->bodies()) {
    if (!body.guide) continue;
    for (const Index i : body.vertices) outer[i] -= std::exchange(force[i], Vec3::Zero());
  }
}

/// Updates the ledger for the present time, which is the end of a substep.
void Simulation::State::account() {
  ledger.time = time;
  ledger.mass = total(mass);
  double twice = 0;
  Vec3 p = Vec3::Zero(), l = Vec3::Zero();
  for (std::size_t i = 0; i < x.size(); ++i) {
    ledger.external += last_dt / 2 * outer[i].dot(v[i]);
    if (inverse_mass[i] == 0) continue;
    const double c = damping[i];
    const Vec3 next = (v[i] + last_dt * inverse_mass[i] * force[i]) / (1 + c * last_dt);
    ledger.damping += last_dt * c * mass[i] * next.dot(v[i]) / 2;
    twice += mass[i] * v[i].dot(next);
    p += mass[i] * v[i];
    l += mass[i] * x[i].cross(v[i]);
  }
  for (const RigidBody& body : bodies->bodies()) {
    if (body.held) continue;
    Vec3 f = Vec3::Zero(), torque = Vec3::Zero();
    for (std::size_t i = 0; i < body.vertices.size(); ++i) {
      f += force[body.vertices[i]];
      torque += body.arm(i).cross(force[body.vertices[i]]);
    }
    twice += body.velocity.dot(body.mass * body.velocity + last_dt * f);
    twice += body.angular_velocity.dot(body.spin + last_dt * torque);
    p += body.mass * body.velocity;
    l += body.mass * body.center.cross(body.velocity) + body.spin;
  }
  ledger.kinetic = twice / 2;
  ledger.momentum = p;
  ledger.angular_momentum = l;
  ledger.elastic = solids->elastic_energy() + shells->elastic_energy();
  ledger.plastic = solids->plastic_work() + shells->plastic_work();
  ledger.numerical = solids->numerical_work() + shells->numerical_work();
  if (!std::isfinite(ledger.kinetic) || !std::isfinite(ledger.elastic))
    throw Error(fmt::format("simulation: energies are no longer finite at time {} s", time));
}

void Simulation::State::change_topology() {
  bool any = options.cutting && cut();
  if (since_edit >= static_cast<std::uint64_t>(options.topology_interval)) {
    any |= options.merging && may_merge && merge(last_dt);
    any |= options.splitting && may_split && break_and_split();
    since_edit = 0;
  }
  if (any) {
    since = x;
    elapsed = 0;
  }
}

bool Simulation::State::cut() {
  bool any = false;
  for (std::size_t i = 0; i < model.cuts.size(); ++i) {
    const double now = covered_depth(model.cuts[i], time);
    if (!(now >= depth[i] + cut_advance[i] || (now >= model.cuts[i].length && depth[i] < now))) continue;
    depth[i] = now;
    TopologyProposal proposal = propose_cut(*topology, reference, model.cuts[i], now);
    if (proposal.empty()) continue;
    ++counts.cuts;
    apply(std::move(proposal));
    any = true;
  }
  return any;
}

bool Simulation::State::merge(double dt) {
  std::vector<LoadedContact> loaded;
  for (const ContactConstraint& c : contacts->constraints()) {
    if (c.is_wall() || !c.solid || !(c.normal_impulse > 0)) continue;
    Contact contact;
    contact.kind = c.kind;
    contact.vertices = c.vertices;
    contact.toi = c.toi;
    contact.normal = c.normal;
    contact.point = Vec3::Zero();
    for (std::size_t i = 0; i < 4; ++i)
      if (c.weights[i] < 0) contact.point -= c.weights[i] * x[c.vertices[i]];
    for (std::size_t i = 0; i < 4; ++i) contact.weights[i] = std::abs(c.weights[i]);
    loaded.push_back({contact, (c.normal_impulse + c.earlier) / dt});
  }
  if (loaded.empty()) return false;
  TopologyProposal proposal = propose_merging(*topology, model.parts, loaded, x, v, mass);
  if (proposal.empty()) return false;
  counts.merges += proposal.moved.size();
  apply(std::move(proposal));
  return true;
}

bool Simulation::State::break_and_split() {
  stress.assign(x.size(), VertexStress());
  solids->add_vertex_stress(stress);
  shells->add_vertex_stress(stress);
  const std::uint64_t before = counts.edits;
  pressed.assign(x.size(), 0);
  for (const ContactConstraint& c : contacts->constraints())
    if (c.normal_impulse + c.earlier > 0)
      for (int i = 0; i < c.size; ++i) pressed[c.vertices[i]] = 1;
  // This edit adds no vertices, and does not change the stress at the existing ones.
  if (TopologyProposal breaking = propose_breaking(*topology, model.parts, x, stress, pressed); !breaking.empty()) {
    counts.breaks += breaking.edit.removed.size();
    apply(std::move(breaking));
  }
  if (TopologyProposal splitting = propose_splitting(*topology, model.parts, x, stress); !splitting.empty()) {
    counts.splits += splitting.edit.new_vertex_ids.size();
    apply(std::move(splitting));
  }
  return counts.edits > before;
}

void Simulation::State::apply(TopologyProposal proposal) {
  const auto energy = [&] { return kinetic_energy(mass, v) + solids->elastic_energy() + shells->elastic_energy(); };
  const double before = energy();
  inherit(proposal, x);
  inherit(proposal, v);
  inherit(proposal, start);
  inherit(proposal, asked_start);
  inherit(proposal, asked_end);
  for (const MovedVertex& moved : proposal.moved) {
    x[moved.vertex] = moved.position;
    v[moved.vertex] = moved.velocity;
  }
  edit(proposal);
  evaluate_forces(0);
  ledger.topology += before - energy();
  ++counts.edits;
  edits.push_back(std::move(proposal));
}

/// Applies an edit to everything that does not depend on positions and velocities.
void Simulation::State::edit(const TopologyProposal& proposal) {
  inherit(proposal, reference);
  for (const VertexOrigin& origin : proposal.new_vertices) {
    bool held = true;
    for (std::size_t i = 0; i < 2; ++i) held &= origin.weights[i] == 0 || fixed[origin.parents[i]];
    fixed.push_back(held);
    origins.push_back(origin.weights[0] == 1 ? origins[origin.parents[0]] : static_cast<Index>(origins.size()));
  }
  topology->apply(proposal.edit);
  const ElementHeritage heritage = heritage_of(proposal, topology->mesh());
  solids->update(topology->mesh(), reference, x, heritage);
  shells->update(topology->mesh(), reference, x, heritage);
  pressure.update(topology->mesh());
  bodies->resize(reference.size());
  if (x.size() == reference.size()) renew_masses();
  if (ContactDetection* detection = contacts->detection())
    detection->follow(proposal.edit, thickness(), reference, origins);
}

void Simulation::State::replay(std::vector<TopologyProposal> from) {
  if (!edits.empty()) throw InputError("checkpoint", "", "is read into a simulation whose mesh has changed already");
  for (const TopologyProposal& proposal : from) {
    inherit(proposal, x);
    inherit(proposal, v);
    edit(proposal);
  }
  edits = std::move(from);
}

Simulation::Simulation(Model model, SimulationOptions options, Executor& executor)
    : state_(std::make_unique<State>(std::move(model), std::move(options), executor)) {}
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;
Simulation::~Simulation() = default;

bool Simulation::advance_to(double time, const std::function<bool(double)>& go_on) {
  State& s = *state_;
  if (!(time >= s.time) || !std::isfinite(time))
    throw ConfigError(fmt::format("simulation: cannot advance from {} s to {} s", s.time, time));
  s.start = s.x;
  int group = 0;
  for (bool last = s.time == time; !last;) {
    const double dt = s.next_step(time, last);
    const bool query = last || ++group >= s.options.substeps_per_query;
    s.substep(dt, query);
    if (last) s.time = time;
    s.evaluate_forces(dt);
    s.hinder(s.v, s.x1, s.x, dt);
    s.account();
    if (query) {
      group = 0;
      s.change_topology();
    }
    if (!last && go_on && !go_on(s.time)) return false;
  }
  return true;
}

double Simulation::time() const { return state_->time; }
const Topology& Simulation::topology() const { return *state_->topology; }
std::span<const Vec3> Simulation::positions() const { return state_->x; }
std::span<const Vec3> Simulation::velocities() const { return state_->v; }
std::span<const Vec3> Simulation::start_positions() const { return state_->start; }
std::optional<AskedQuery> Simulation::last_query() const {
  if (!state_->contacts->detection()) return std::nullopt;
  return AskedQuery{state_->asked_start, state_->asked_end, state_->asked_separation};
}
std::vector<double> Simulation::thickness() const { return state_->thickness(); }
double Simulation::mass(Index vertex) const { return state_->mass[vertex]; }
const Ledger& Simulation::ledger() const { return state_->ledger; }

SimulationCounts Simulation::take_counts() {
  const ContactCounts c = std::exchange(state_->contacts->counts(), {});
  SimulationCounts counts = std::exchange(state_->counts, {});
  counts.queries = c.queries;
  counts.retests = c.retests;
  counts.inter = c.inter;
  counts.intra = c.intra;
  counts.adjacent = c.adjacent;
  counts.leaving = c.leaving;
  counts.ignored = c.ignored;
  counts.held = c.held;
  counts.unresolved = c.unresolved;
  return counts;
}

void Simulation::archive(Archive& archive) {
  State& s = *state_;
  std::uint64_t kind[3] = {0x564f4c4343440001u, s.model.mesh.vertex_count(), s.model.mesh.element_slots()};
  const std::uint64_t expected[3] = {kind[0], kind[1], kind[2]};
  for (std::uint64_t& k : kind) archive(k);
  if (!std::equal(kind, kind + 3, expected)) throw InputError("checkpoint", "", "of another model or version");
  std::uint64_t edit_count = s.edits.size();
  archive(edit_count);
  if (archive.reading()) {
    std::vector<TopologyProposal> edits(static_cast<std::size_t>(edit_count));
    for (TopologyProposal& proposal : edits) archive_proposal(archive, proposal);
    s.replay(std::move(edits));
  } else {
    for (TopologyProposal& proposal : s.edits) archive_proposal(archive, proposal);
  }
  archive(s.time);
  archive(s.last_dt);
  for (std::vector<Vec3>* values : {&s.x, &s.v, &s.start, &s.outer, &s.force, &s.since, &s.asked_start, &s.asked_end}) {
    archive(*values);
    if (values->size() != s.reference.size()) throw InputError("checkpoint", "", "damaged");
  }
  archive_plain(archive, s.ledger);
  archive_plain(archive, s.counts);
  archive_plain(archive, s.contacts->counts());
  archive(s.depth);
  archive(s.since_edit);
  archive(s.elapsed);
  archive(s.asked_separation);
  s.solids->archive(archive);
  s.shells->archive(archive);
  // The replayed edits did not have the deformation of pieces, from which their shapes at rest follow.
  if (archive.reading()) s.renew_masses();
  s.bodies->archive(archive);
  if (ContactDetection* detection = s.contacts->detection()) detection->archive(archive);
  s.x1.resize(s.x.size());
}

}  // namespace volccd::simulation
