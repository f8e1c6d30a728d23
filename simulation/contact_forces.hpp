// Impact forces from contacts {t', d} (Algorithm 1, lines 11 to 19): impulses with friction on vertices and rigid
// bodies.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <volccd/query/pairs.hpp>
#include <volccd/simulation/contact_detection.hpp>
#include <volccd/simulation/rigid_bodies.hpp>

namespace volccd::simulation {

/// What contacts act on, at the end of a step that nothing has stopped yet. Vertices of bodies follow their bodies.
struct MovingVertices {
  std::span<const double> inverse_mass;  ///< 0: held, or of a body
  std::span<Vec3> x1, v;
  RigidBodies& bodies;
};

/// What impulses took and gave.
struct ContactWork {
  double total = 0;                                             ///< kinetic energy lost, friction included
  double friction = 0;                                          ///< force times sliding
  Vec3 impulse = Vec3::Zero(), angular_impulse = Vec3::Zero();  ///< from walls and from what is held
};

/// One contact, with its relative motion linear in that of its vertices: gap at the end = offset + normal . sum(w x1).
struct ContactConstraint {
  FeatureKind kind = FeatureKind::vf;
  std::array<Index, 4> features{};  ///< names the pair; of a wall: {kNone, wall, vertex, 0}
  std::array<Index, 4> vertices{};
  std::array<double, 4> weights{};
  int size = 4;  ///< vertices in use
  Vec3 normal = Vec3::Zero();
  double toi = 0;
  double left = 0;   ///< seconds from the contact to the end of the substep: by what an impulse moves its vertices
  double share = 0;  ///< the same, of the substep
  double offset = 0;
  double goal = 0;  ///< gap at the end that the contact is to have at least
  double friction = 0, restitution = 0;
  double rebound = 0;           ///< normal velocity that it is to have afterwards, at least; negative: may come nearer
  Vec3 impulse = Vec3::Zero();  ///< on the first feature so far: normal part and tangential part
  double normal_impulse = 0;
  double earlier = 0;       ///< normal impulse before the geometry was renewed
  double inverse_mass = 0;  ///< along the normal
  bool solid = true;
  ContactClass contact_class = ContactClass::inter;

  bool is_wall() const { return features[0] == kNone; }
};

/// Sequential impulses (projected Gauss-Seidel) in the order of time. An impulse J at time t' changes velocities by J/m
/// and positions at the end by (1 - t') dt J/m: of a single inelastic contact, that is the force that takes the
/// penetration depth d back; several together are iterated, and what positions still lack then is corrected without
/// velocity. Momentum is exact. Serial; the result depends on the constraints alone.
class ContactForces {
 public:
  /// Begins a step: no constraints.
  void clear() { constraints_.clear(); }
  std::vector<ContactConstraint>& constraints() { return constraints_; }
  const std::vector<ContactConstraint>& constraints() const { return constraints_; }

  /// Adds constraints between the vertices as they move now, but those that nothing can move. Of a pair that is there,
  /// the geometry is renewed.
  void add(std::span<const ContactConstraint> added, const MovingVertices& moving);

  /// Applies impulses, `sweeps` times over all, then moves positions to their goals. Writes the vertices of bodies.
  void solve(const MovingVertices& moving, int sweeps, ContactWork& work);

  static double gap(const ContactConstraint& c, std::span<const Vec3> x1);

 private:
  Vec3 relative_velocity(const ContactConstraint& c, const MovingVertices& moving) const;
  Vec3 relative_shift(const ContactConstraint& c, const MovingVertices& moving) const;
  double inverse_mass(const ContactConstraint& c, const Vec3& direction, const MovingVertices& moving) const;
  void apply(const ContactConstraint& c, const Vec3& impulse, const MovingVertices& moving, ContactWork& work);
  void shift(const ContactConstraint& c, const Vec3& impulse_times_time, const MovingVertices& moving);
  /// Both return by how much the relative velocity changed.
  double solve_normal(ContactConstraint& c, const MovingVertices& moving, ContactWork& work);
  double solve_friction(ContactConstraint& c, const MovingVertices& moving, ContactWork& work);
  void begin_bodies(const MovingVertices& moving);
  void end_bodies(const MovingVertices& moving);

  /// Displacements of a body since begin_bodies(), to be put into its pose by end_bodies().
  struct BodyShift {
    Vec3 center = Vec3::Zero(), turn = Vec3::Zero();
    Eigen::Matrix3d inverse_inertia;
  };
  std::vector<ContactConstraint> constraints_;
  std::vector<BodyShift> shifts_;
};

}  // namespace volccd::simulation
