#include <volccd/simulation/detail/simulation_state.hpp>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <volccd/core/error.hpp>
#include <volccd/simulation/detail/check_model.hpp>
#include <volccd/simulation/elements/shell_forces.hpp>
#include <volccd/simulation/elements/solid_forces.hpp>

namespace volccd::simulation {
namespace {

/// Default separation, as a fraction of the shortest edge, and greatest one, of the thickness of the thinnest shell.
constexpr double kSeparationOfEdge = 0.01, kSeparationOfThickness = 0.1;
/// Distance that a blade moves between two cuts, in mean edges of the body.
constexpr double kCutAdvance = 0.25;

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

}  // namespace

Simulation::State::State(Model m, SimulationOptions o, Executor& e)
    : model((detail::check_model(m), std::move(m))),
      options((detail::check_options(o), std::move(o))),
      executor(e),
      topology(std::in_place, model.mesh, e),
      solids(make_solid_forces(model)),
      shells(make_shell_forces(model)),
      pressure(model),
      x(model.positions),
      v(model.velocities),
      reference(model.positions),
      start(model.positions),
      fixed(model.mesh.vertex_count(), 0),
      depth(model.cuts.size(), 0),
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
  for (const Body& body : model.bodies) {
    may_split |= body.material.failure_stress < kNever || body.material.failure_strain < kNever ||
                 body.material.breaking_strain < kNever;
    may_merge |= body.material.merging_force < kNever && body.material.merging_distance > 0;
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
  const double separation = options.separation < 0 ? choose_separation() : options.separation;
  std::unique_ptr<ContactDetection> detection;
  if (options.contacts) {
    ContactDetection::Config config;
    config.pipeline = options.pipeline;
    config.features = options.features;
    config.adjacent = options.adjacent_contacts;
    config.excluded = options.excluded;
    for (std::size_t i = 0; i < model.bodies.size(); ++i)
      if (model.bodies[i].rigid)
        config.excluded.emplace_back(static_cast<std::int32_t>(i), static_cast<std::int32_t>(i));
    config.separation = separation;
    config.lists = options.lists;
    detection = std::make_unique<ContactDetection>(*topology, thickness(), reference, config, executor);
  }
  contacts = std::make_unique<ContactResponse>(
      std::move(detection), model.bodies, model.walls,
      ContactResponse::Config{options.contact_passes, options.contact_iterations, separation});
}

void Simulation::State::renew_masses() {
  mass.assign(x.size(), 0);
  solids->add_masses(mass);
  shells->add_masses(mass);
  inverse_mass.assign(x.size(), 0);
  damping.assign(x.size(), 0);
  object_of.assign(x.size(), 0);
  const Features& features = topology->features();
  for (Index i = 0; i < x.size(); ++i) {
    const auto elements = features.vertex_elements(i);
    if (!elements.empty()) object_of[i] = static_cast<Index>(topology->mesh().object(elements[0]));
    for (Index o : elements)
      damping[i] += model.bodies[static_cast<std::size_t>(topology->mesh().object(o))].material.damping /
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
      result[o] = model.bodies[static_cast<std::size_t>(mesh.object(o))].thickness;
  return result;
}

double Simulation::State::next_step(double until, bool& last) const {
  const double max = std::min(
      {options.max_step, options.step_safety * solids->stable_step(), options.step_safety * shells->stable_step()});
  const double left = until - time;
  const double steps = std::ceil(left / max * (1 - 1e-12));
  last = !(steps > 1);
  if (!(max > 0) || time + left / std::max(steps, 1.0) == time)
    throw Error(fmt::format("simulation: the stable step is {} s at time {} s", max, time));
  return last ? left : left / steps;
}

void Simulation::State::substep(double dt) {
  bodies->mark();
  bodies->follow_guides(time + dt, dt);
  kick(dt);
  unhindered = v;
  for (std::size_t i = 0; i < x.size(); ++i) x1[i] = inverse_mass[i] > 0 ? Vec3(x[i] + dt * v[i]) : x[i];
  bodies->drift(dt);
  bodies->write_vertices(x1, v);
  collide(dt);
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

void Simulation::State::collide(double dt) {
  if (options.contacts) {
    asked_start = x;
    asked_end = x1;
  }
  ContactWork work;
  contacts->substep(x, object_of, dt, {inverse_mass, x1, v, *bodies}, work);
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
  for (bool last = s.time == time; !last;) {
    const double dt = s.next_step(time, last);
    s.substep(dt);
    if (last) s.time = time;
    s.evaluate_forces(dt);
    s.hinder(s.v, s.x1, s.x, dt);
    s.account();
    s.change_topology();
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
  return AskedQuery{state_->asked_start, state_->asked_end, state_->contacts->detection()->separation()};
}
std::vector<double> Simulation::thickness() const { return state_->thickness(); }
double Simulation::mass(Index vertex) const { return state_->mass[vertex]; }
const Ledger& Simulation::ledger() const { return state_->ledger; }

SimulationCounts Simulation::drain_counts() {
  const ContactCounts c = std::exchange(state_->contacts->counts(), {});
  SimulationCounts counts = std::exchange(state_->counts, {});
  counts.queries = c.queries;
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
  for (std::vector<Vec3>* values : {&s.x, &s.v, &s.start, &s.outer, &s.force, &s.asked_start, &s.asked_end}) {
    archive(*values);
    if (values->size() != s.reference.size()) throw InputError("checkpoint", "", "damaged");
  }
  archive_plain(archive, s.ledger);
  archive_plain(archive, s.counts);
  archive_plain(archive, s.contacts->counts());
  archive(s.depth);
  archive(s.since_edit);
  s.solids->archive(archive);
  s.shells->archive(archive);
  // The replayed edits did not have the deformation of pieces, from which their shapes at rest follow.
  if (archive.reading()) s.renew_masses();
  s.bodies->archive(archive);
  s.x1.resize(s.x.size());
}

}  // namespace volccd::simulation
