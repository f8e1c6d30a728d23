// The part of the time loop that cuts, merges, breaks and splits.
#include <volccd/simulation/detail/simulation_state.hpp>

#include <cmath>

#include <volccd/core/error.hpp>
#include <volccd/simulation/topology/element_breaking.hpp>
#include <volccd/simulation/topology/element_cutting.hpp>
#include <volccd/simulation/topology/node_merging.hpp>
#include <volccd/simulation/topology/node_splitting.hpp>

namespace volccd::simulation {

void Simulation::State::change_topology() {
  if (options.cutting) cut();
  if (since_edit >= static_cast<std::uint64_t>(options.topology_interval)) {
    if (options.merging && may_merge) merge(last_dt);
    if (options.splitting && may_split) break_and_split();
    since_edit = 0;
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
  TopologyProposal proposal = propose_merging(*topology, model.bodies, loaded, x, v, mass);
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
  if (TopologyProposal breaking = propose_breaking(*topology, model.bodies, x, stress, pressed); !breaking.empty()) {
    counts.breaks += breaking.edit.removed.size();
    apply(std::move(breaking));
  }
  if (TopologyProposal splitting = propose_splitting(*topology, model.bodies, x, stress); !splitting.empty()) {
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

}  // namespace volccd::simulation
