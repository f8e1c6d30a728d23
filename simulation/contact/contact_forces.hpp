// Impact forces from contacts {t', d} (Algorithm 1, lines 11 to 19): impulses with friction on vertices and rigid
// bodies.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/query/pairs.hpp>
#include <volccd/simulation/contact/contact_detection.hpp>
#include <volccd/simulation/elements/rigid_bodies.hpp>

namespace volccd::simulation {

/// The state that contacts act on: positions and velocities at the end of a step, before the response. Vertices of
/// rigid bodies follow their bodies.
struct MovingVertices {
  std::span<const double> inverse_mass;  ///< by vertex; 0: fixed, or of a rigid body
  std::span<Vec3> x1, v;
  RigidBodies& bodies;
};

/// Energy and momentum that the impulses have changed.
struct ContactWork {
  double total = 0;                                             ///< kinetic energy lost, friction included
  double friction = 0;                                          ///< work of friction forces
  double external = 0;                                          ///< work of what moves guided bodies
  Vec3 impulse = Vec3::Zero(), angular_impulse = Vec3::Zero();  ///< from walls, fixed vertices, guided bodies
};

/// One contact. Its gap is linear in the positions of its vertices: gap at the end of the substep = offset + normal .
/// sum(w x1).
struct ContactConstraint {
  FeatureKind kind = FeatureKind::vf;
  std::array<Index, 4> features{};  ///< identify the pair; for a wall: {kNone, wall, vertex, 0}
  std::array<Index, 4> vertices{};
  std::array<double, 4> weights{};
  int size = 4;  ///< vertices in use
  Vec3 normal = Vec3::Zero();
  double toi = 0;
  double left = 0;   ///< seconds from the contact to the end of the substep: displacement for a change of velocity
  double share = 0;  ///< the same, as a fraction of the substep
  double offset = 0;
  double goal = 0;  ///< least gap at the end of the substep
  double friction = 0, restitution = 0;
  double rebound = 0;           ///< least normal velocity afterwards; negative: the features may approach
  Vec3 impulse = Vec3::Zero();  ///< on the first feature so far, normal and tangential part
  double normal_impulse = 0;
  double earlier = 0;       ///< normal impulse before the geometry was updated
  double inverse_mass = 0;  ///< along the normal
  bool solid = true;        ///< no shell is involved
  ContactClass contact_class = ContactClass::inter;

  bool is_wall() const { return features[0] == kNone; }
};

/// Sequential impulses (projected Gauss-Seidel) in the order of time. An impulse J at time t' changes velocities by J/m
/// and positions at the end by (1 - t') dt J/m: for a single inelastic contact, this is the force that removes the
/// penetration depth d. Several contacts are iterated; penetration that remains then is removed by changing positions
/// without velocities. Momentum is conserved to rounding. Serial; the result depends on the constraints alone.
class ContactForces {
 public:
  /// Begins a step: removes all constraints.
  void clear() { constraints_.clear(); }
  std::vector<ContactConstraint>& constraints() { return constraints_; }
  const std::vector<ContactConstraint>& constraints() const { return constraints_; }

  /// Adds constraints for the present motion of the vertices, except for those whose vertices are all fixed. If a pair
  /// has a constraint already, its geometry is updated.
  void add(std::span<const ContactConstraint> added, const MovingVertices& moving);

  /// Applies impulses in up to `sweeps` passes over all constraints, then moves positions to their goals. Updates the
  /// vertices of rigid bodies.
  void solve(const MovingVertices& moving, int sweeps, ContactWork& work);

  static double gap(const ContactConstraint& c, std::span<const Vec3> x1);

 private:
  Vec3 relative_velocity(const ContactConstraint& c, const MovingVertices& moving) const;
  Vec3 relative_shift(const ContactConstraint& c, const MovingVertices& moving) const;
  double inverse_mass(const ContactConstraint& c, const Vec3& direction, const MovingVertices& moving) const;
  void apply(const ContactConstraint& c, const Vec3& impulse, const MovingVertices& moving, ContactWork& work);
  void shift(const ContactConstraint& c, const Vec3& impulse_times_time, const MovingVertices& moving);
  /// Both return the change of the relative velocity.
  double solve_normal(ContactConstraint& c, const MovingVertices& moving, ContactWork& work);
  double solve_friction(ContactConstraint& c, const MovingVertices& moving, ContactWork& work);
  void begin_bodies(const MovingVertices& moving);
  void end_bodies(const MovingVertices& moving);

  /// Displacement of a body since begin_bodies(), which end_bodies() adds to its pose.
  struct BodyShift {
    Vec3 center = Vec3::Zero(), turn = Vec3::Zero();
    Eigen::Matrix3d inverse_inertia;
  };
  std::vector<ContactConstraint> constraints_;
  std::vector<BodyShift> shifts_;
};

}  // namespace volccd::simulation
