// The state of a simulation, and the parts of its time loop.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <volccd/simulation/contact/contact_response.hpp>
#include <volccd/simulation/elements/pressure_forces.hpp>
#include <volccd/simulation/elements/rigid_bodies.hpp>
#include <volccd/simulation/simulation.hpp>
#include <volccd/simulation/topology/topology_proposal.hpp>

namespace volccd::simulation {

struct Simulation::State {
  State(Model m, SimulationOptions o, Executor& e);

  // Preparation.
  double choose_separation();
  void make_detection();
  void renew_masses();
  std::vector<double> thickness() const;

  // A substep.
  double next_step(double until, bool& last) const;
  void substep(double dt);
  void kick(double dt);
  void damp_bodies(double dt);
  void collide(double dt);
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
  std::vector<Vec3> asked_start, asked_end;  ///< of the last query

  // Data that follow from this state.
  std::vector<double> mass, inverse_mass, damping;
  std::vector<Index> object_of;
  std::vector<double> cut_advance;
  std::vector<Index> origins;  ///< by vertex: the vertex of the initial mesh of which it is a copy, or itself
  bool may_split = false, may_merge = false;
  std::vector<Vec3> x1;          ///< positions after a substep; then those before it
  std::vector<Vec3> unhindered;  ///< velocities before contacts
  std::vector<VertexStress> stress;
  std::vector<char> pressed;
};

}  // namespace volccd::simulation
