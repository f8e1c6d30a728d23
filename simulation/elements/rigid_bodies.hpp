// Rigid bodies.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include <volccd/simulation/archive.hpp>
#include <volccd/simulation/model.hpp>

namespace volccd::simulation {

/// Mass and inertia are those of the lumped masses of its vertices, which include the masses of deformable elements
/// attached to them. So energy and momentum are sums over vertices, as for deformable bodies.
struct RigidBody {
  bool held = false;  ///< no force moves the body: one of its vertices is fixed, or it is guided
  std::optional<Guide> guide = {};
  std::vector<Vec3> guided_from;     ///< of a guided body: initial positions, by vertex
  Vec3 displacement = Vec3::Zero();  ///< of a guided body
  double mass = 0;
  Eigen::Matrix3d inertia,
      inverse_inertia;  ///< about the centre, in the body's frame; pseudo-inverse for a line or a point
  std::vector<Index> vertices;
  std::vector<Vec3> local;  ///< position relative to the centre, in the body's frame, by vertex

  Vec3 center = Vec3::Zero(), velocity = Vec3::Zero();
  Vec3 spin = Vec3::Zero();  ///< angular momentum about the centre
  Vec3 angular_velocity = Vec3::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Vec3 marked_center = Vec3::Zero();
  Eigen::Quaterniond marked_orientation = Eigen::Quaterniond::Identity();

  Vec3 arm(std::size_t i) const { return orientation * local[i]; }
  /// Inverse inertia in the world frame.
  Eigen::Matrix3d inverse_inertia_now() const;
};

class RigidBodies {
 public:
  /// Makes a RigidBody for each rigid body of the model that has elements. Its initial velocity is the rigid motion
  /// with the momentum and angular momentum of the model's velocities. Throws InputError for a vertex of two rigid
  /// bodies, and for a body without mass. A body with a guide is at rest at first.
  RigidBodies(const Model& model, std::span<const double> mass);

  std::vector<RigidBody>& bodies() { return bodies_; }
  const std::vector<RigidBody>& bodies() const { return bodies_; }
  /// By vertex: index of its body, kNone if it belongs to none.
  std::span<const Index> body_of() const { return body_of_; }

  /// Moves guided bodies from where they are to their displacement at `time`, dt later, with constant velocity.
  void follow_guides(double time, double dt);
  /// Changes momentum and spin by the forces on the vertices during dt, and sets the angular velocity that follows from
  /// the new spin.
  void kick(std::span<const Vec3> force, double dt);
  /// Moves the bodies for dt: the centre along a straight line, the orientation with the angular velocity at the middle
  /// of the step, which becomes the body's. The spin does not change. Second order.
  void drift(double dt);
  /// Writes the positions and velocities of the vertices that follow from the state of the bodies. A vertex of a guided
  /// body is at its initial position plus the displacement, rounded once.
  void write_vertices(std::span<Vec3> x, std::span<Vec3> v) const;
  void write_velocities(std::span<Vec3> v) const;

  /// Stores the present poses in marked_center and marked_orientation.
  void mark();

  /// Vertices were added to the mesh; they belong to no body.
  void resize(std::size_t vertices) { body_of_.resize(vertices, kNone); }

  void archive(Archive& archive);

 private:
  void measure(RigidBody& body, const Model& model, std::span<const double> mass);

  std::vector<RigidBody> bodies_;
  std::vector<Index> body_of_;
};

/// q rotated by the rotation vector w (world frame).
Eigen::Quaterniond turned(const Eigen::Quaterniond& q, const Vec3& w);

}  // namespace volccd::simulation
