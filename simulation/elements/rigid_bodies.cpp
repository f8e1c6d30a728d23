#include <volccd/simulation/elements/rigid_bodies.hpp>

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include <volccd/core/error.hpp>

namespace volccd::simulation {
namespace {

/// Pseudo-inverse of a positive semidefinite matrix: there is no rotation about axes without inertia (the axis of a
/// line).
Eigen::Matrix3d pseudo_inverse(const Eigen::Matrix3d& inertia) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertia);
  const Vec3 values = solver.eigenvalues();
  Vec3 inverse = Vec3::Zero();
  for (int i = 0; i < 3; ++i)
    if (values[i] > 1e-12 * values[2]) inverse[i] = 1 / values[i];
  return solver.eigenvectors() * inverse.asDiagonal() * solver.eigenvectors().transpose();
}

}  // namespace

Vec3 Guide::displacement(double time) const {
  const auto next = std::ranges::upper_bound(path, time, {}, &std::pair<double, Vec3>::first);
  if (next == path.begin()) return path.front().second;
  const auto& [t0, d0] = *(next - 1);
  if (next == path.end()) return d0;
  return d0 + (time - t0) / (next->first - t0) * (next->second - d0);
}

Eigen::Quaterniond turned(const Eigen::Quaterniond& q, const Vec3& w) {
  const double angle = w.norm();
  if (angle == 0) return q;
  return (Eigen::Quaterniond(Eigen::AngleAxisd(angle, w / angle)) * q).normalized();
}

Eigen::Matrix3d RigidBody::inverse_inertia_now() const {
  const Eigen::Matrix3d r = orientation.toRotationMatrix();
  return r * inverse_inertia * r.transpose();
}

RigidBodies::RigidBodies(const Model& model, std::span<const double> mass)
    : body_of_(model.mesh.vertex_count(), kNone) {
  std::vector<Index> body_of_object(model.bodies.size(), kNone);
  const Mesh& mesh = model.mesh;
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (!mesh.is_live(o)) continue;
    const auto object = static_cast<std::size_t>(mesh.object(o));
    if (!model.bodies[object].rigid) continue;
    if (body_of_object[object] == kNone) {
      body_of_object[object] = static_cast<Index>(bodies_.size());
      bodies_.emplace_back();
    }
    for (Index v : mesh.vertices(o)) {
      if (body_of_[v] == body_of_object[object]) continue;
      if (body_of_[v] != kNone) throw InputError("model", "mesh", v, "is a vertex of two rigid bodies");
      body_of_[v] = body_of_object[object];
    }
  }
  for (Index v = 0; v < mesh.vertex_count(); ++v)
    if (body_of_[v] != kNone) bodies_[body_of_[v]].vertices.push_back(v);
  for (Index v : model.fixed)
    if (body_of_[v] != kNone) bodies_[body_of_[v]].held = true;
  for (const Guide& guide : model.guides) {
    const Index b = body_of_object[static_cast<std::size_t>(guide.object)];
    if (b == kNone) continue;
    bodies_[b].held = true;
    bodies_[b].guide = guide;
    for (const Index v : bodies_[b].vertices) bodies_[b].guided_from.push_back(model.positions[v]);
  }
  for (RigidBody& body : bodies_) measure(body, model, mass);
}

void RigidBodies::measure(RigidBody& body, const Model& model, std::span<const double> mass) {
  Vec3 momentum = Vec3::Zero();
  for (Index v : body.vertices) {
    body.mass += mass[v];
    body.center += mass[v] * model.positions[v];
    momentum += mass[v] * model.velocities[v];
  }
  if (!(body.mass > 0)) throw InputError("model", "bodies", "a rigid body has no mass");
  body.center /= body.mass;
  body.velocity = momentum / body.mass;
  body.inertia.setZero();
  for (Index v : body.vertices) {
    const Vec3 r = model.positions[v] - body.center;
    body.local.push_back(r);
    body.inertia += mass[v] * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
    body.spin += mass[v] * r.cross(model.velocities[v] - body.velocity);
  }
  body.inverse_inertia = pseudo_inverse(body.inertia);
  if (body.held) {
    body.velocity.setZero();
    body.spin.setZero();
  }
  body.angular_velocity = body.inverse_inertia * body.spin;
  // Removes the part of the spin about axes without inertia, which comes from rounding or from given velocities that
  // are no rigid motion.
  body.spin = body.inertia * body.angular_velocity;
}

void RigidBodies::follow_guides(double time, double dt) {
  for (RigidBody& body : bodies_) {
    if (!body.guide) continue;
    const Vec3 next = body.guide->displacement(time);
    body.velocity = (next - body.displacement) / dt;
    body.center += next - body.displacement;
    body.displacement = next;
  }
}

void RigidBodies::kick(std::span<const Vec3> force, double dt) {
  for (RigidBody& body : bodies_) {
    if (body.held) continue;
    Vec3 sum = Vec3::Zero(), torque = Vec3::Zero();
    for (std::size_t i = 0; i < body.vertices.size(); ++i) {
      const Vec3& f = force[body.vertices[i]];
      sum += f;
      torque += body.arm(i).cross(f);
    }
    body.velocity += dt / body.mass * sum;
    body.spin += dt * torque;
    body.angular_velocity = body.inverse_inertia_now() * body.spin;
  }
}

void RigidBodies::drift(double dt) {
  for (RigidBody& body : bodies_) {
    if (body.held) continue;
    const Eigen::Quaterniond start = body.orientation;
    body.orientation = turned(start, dt / 2 * body.angular_velocity);
    body.angular_velocity = body.inverse_inertia_now() * body.spin;
    body.orientation = turned(start, dt * body.angular_velocity);
    body.center += dt * body.velocity;
  }
}

void RigidBodies::write_vertices(std::span<Vec3> x, std::span<Vec3> v) const {
  for (const RigidBody& body : bodies_)
    for (std::size_t i = 0; i < body.vertices.size(); ++i) {
      const Vec3 arm = body.arm(i);
      // The positions of fixed bodies do not change in any bit.
      if (!body.held) x[body.vertices[i]] = body.center + arm;
      if (body.guide) x[body.vertices[i]] = body.guided_from[i] + body.displacement;
      v[body.vertices[i]] = body.velocity + body.angular_velocity.cross(arm);
    }
}

void RigidBodies::write_velocities(std::span<Vec3> v) const {
  for (const RigidBody& body : bodies_)
    for (std::size_t i = 0; i < body.vertices.size(); ++i)
      v[body.vertices[i]] = body.velocity + body.angular_velocity.cross(body.arm(i));
}

void RigidBodies::mark() {
  for (RigidBody& body : bodies_) {
    body.marked_center = body.center;
    body.marked_orientation = body.orientation;
  }
}

void RigidBodies::archive(Archive& archive) {
  std::uint64_t count = bodies_.size();
  archive(count);
  if (count != bodies_.size()) throw InputError("checkpoint", "rigid bodies", "of another model");
  for (RigidBody& body : bodies_) {
    std::vector<Vec3> state = {body.center, body.velocity, body.spin, body.angular_velocity, body.displacement};
    std::vector<double> turn(body.orientation.coeffs().data(), body.orientation.coeffs().data() + 4);
    archive(state);
    archive(turn);
    if (!archive.reading()) continue;
    if (state.size() != 5 || turn.size() != 4) throw InputError("checkpoint", "rigid bodies", "damaged");
    body.center = state[0];
    body.velocity = state[1];
    body.spin = state[2];
    body.angular_velocity = state[3];
    body.displacement = state[4];
    body.orientation.coeffs() = Eigen::Map<const Eigen::Vector4d>(turn.data());
  }
  mark();
}

}  // namespace volccd::simulation
