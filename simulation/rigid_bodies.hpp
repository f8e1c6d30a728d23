// Parts that move as one body.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Geometry>

#include <volccd/simulation/archive.hpp>
#include <volccd/simulation/model.hpp>

namespace volccd::simulation {

/// Mass and inertia are those of the lumped masses of its vertices, those included that deformable elements glued to it
/// put there: so energy and momentum are the sums over vertices that they are elsewhere.
struct RigidBody {
  bool held = false;  ///< a vertex of it is fixed: it stands still
  double mass = 0;
  Eigen::Matrix3d inertia,
      inverse_inertia;  ///< about the centre, in the body's frame; a line's or a point's is pseudo-inverted
  std::vector<Index> vertices;
  std::vector<Vec3> local;  ///< from the centre, in the body's frame

  Vec3 center = Vec3::Zero(), velocity = Vec3::Zero();
  Vec3 spin = Vec3::Zero();  ///< angular momentum about the centre
  Vec3 angular_velocity = Vec3::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Vec3 marked_center = Vec3::Zero();
  Eigen::Quaterniond marked_orientation = Eigen::Quaterniond::Identity();

  Vec3 arm(std::size_t i) const { return orientation * local[i]; }
  /// Inverse inertia in the frame of the world.
  Eigen::Matrix3d inverse_inertia_now() const;
};

class RigidBodies {
 public:
  /// A body for each rigid part that has elements. Initial velocities are the rigid motion with the momentum and
  /// angular momentum of the model's. Throws InputError for a vertex of two rigid parts, and for a body without mass.
  RigidBodies(const Model& model, std::span<const double> mass);

  std::vector<RigidBody>& bodies() { return bodies_; }
  const std::vector<RigidBody>& bodies() const { return bodies_; }
  /// A vertex; kNone: of no body.
  std::span<const Index> body_of() const { return body_of_; }

  /// Forces on the vertices change momentum and spin over dt; angular velocity is that which the spin has now.
  void kick(std::span<const Vec3> force, double dt);
  /// Moves by dt: the centre straight, the orientation with the angular velocity of the middle of the step (which it
  /// leaves behind as the body's); spin stays exactly. Second order.
  void drift(double dt);
  /// Positions and velocities of the vertices by the state of the bodies.
  void write_vertices(std::span<Vec3> x, std::span<Vec3> v) const;
  void write_velocities(std::span<Vec3> v) const;

  /// Keeps the poses of the moment as marked_center and marked_orientation.
  void mark();

  /// Vertices were added to the mesh; they belong to no body.
  void resize(std::size_t vertices) { body_of_.resize(vertices, kNone); }

  void archive(Archive& archive);

 private:
  void measure(RigidBody& body, const Model& model, std::span<const double> mass);

  std::vector<RigidBody> bodies_;
  std::vector<Index> body_of_;
};

/// q turned by the rotation vector w (world frame).
Eigen::Quaterniond turned(const Eigen::Quaterniond& q, const Vec3& w);

}  // namespace volccd::simulation
