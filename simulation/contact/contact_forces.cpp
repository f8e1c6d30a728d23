#include <volccd/simulation/contact/contact_forces.hpp>

#include <algorithm>
#include <cmath>
#include <tuple>

#include <Eigen/Geometry>

namespace volccd::simulation {
namespace {

/// Sweeps end when changes are below this fraction of those of the first sweep.
constexpr double kSettled = 1e-4;

bool same_pair(const ContactConstraint& a, const ContactConstraint& b) {
  return a.kind == b.kind && a.features == b.features;
}

bool pair_less(const ContactConstraint& a, const ContactConstraint& b) {
  return std::tie(a.kind, a.features) < std::tie(b.kind, b.features);
}

bool time_less(const ContactConstraint& a, const ContactConstraint& b) {
  return a.toi != b.toi ? a.toi < b.toi : pair_less(a, b);
}

}  // namespace

double ContactForces::gap(const ContactConstraint& c, std::span<const Vec3> x1) {
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < c.size; ++i) sum += c.weights[i] * x1[c.vertices[i]];
  return c.offset + c.normal.dot(sum);
}

Vec3 ContactForces::relative_velocity(const ContactConstraint& c, const MovingVertices& moving) const {
  const std::span<const Index> body_of = moving.bodies.body_of();
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < c.size; ++i) {
    const Index v = c.vertices[i];
    if (body_of[v] == kNone) {
      sum += c.weights[i] * moving.v[v];
    } else {
      const RigidBody& body = moving.bodies.bodies()[body_of[v]];
      sum += c.weights[i] * (body.velocity + body.angular_velocity.cross(moving.x1[v] - body.center));
    }
  }
  return sum;
}

/// Change of the relative position by the displacements of bodies, which are not in x1 yet.
Vec3 ContactForces::relative_shift(const ContactConstraint& c, const MovingVertices& moving) const {
  const std::span<const Index> body_of = moving.bodies.body_of();
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < c.size; ++i)
    if (const Index v = c.vertices[i]; body_of[v] != kNone) {
      const BodyShift& s = shifts_[body_of[v]];
      sum += c.weights[i] * (s.center + s.turn.cross(moving.x1[v] - moving.bodies.bodies()[body_of[v]].center));
    }
  return sum;
}

double ContactForces::inverse_mass(const ContactConstraint& c, const Vec3& direction,
                                   const MovingVertices& moving) const {
  const std::span<const Index> body_of = moving.bodies.body_of();
  double sum = 0;
  for (int i = 0; i < c.size; ++i) {
    const Index b = body_of[c.vertices[i]];
    if (b == kNone) {
      sum += c.weights[i] * c.weights[i] * moving.inverse_mass[c.vertices[i]];
      continue;
    }
    const RigidBody& body = moving.bodies.bodies()[b];
    bool first = !body.held;
    for (int j = 0; j < i; ++j) first &= body_of[c.vertices[j]] != b;
    if (!first) continue;
    double weight = 0;
    Vec3 arm = Vec3::Zero();
    for (int j = i; j < c.size; ++j) {
      if (body_of[c.vertices[j]] != b) continue;
      weight += c.weights[j];
      arm += c.weights[j] * (moving.x1[c.vertices[j]] - body.center);
    }
    const Vec3 turn = arm.cross(direction);
    sum += weight * weight / body.mass + turn.dot(shifts_[b].inverse_inertia * turn);
  }
  return sum;
}

void ContactForces::shift(const ContactConstraint& c, const Vec3& amount, const MovingVertices& moving) {
  const std::span<const Index> body_of = moving.bodies.body_of();
  for (int i = 0; i < c.size; ++i) {
    const Index v = c.vertices[i];
    const Vec3 part = c.weights[i] * amount;
    if (body_of[v] == kNone) {
      moving.x1[v] += moving.inverse_mass[v] * part;
      continue;
    }
    const RigidBody& body = moving.bodies.bodies()[body_of[v]];
    if (body.held) continue;
    BodyShift& s = shifts_[body_of[v]];
    s.center += part / body.mass;
    s.turn += s.inverse_inertia * (moving.x1[v] - body.center).cross(part);
  }
}

void ContactForces::apply(const ContactConstraint& c, const Vec3& impulse, const MovingVertices& moving,
                          ContactWork& work) {
  const std::span<const Index> body_of = moving.bodies.body_of();
  for (int i = 0; i < c.size; ++i) {
    const Index v = c.vertices[i];
    const Vec3 part = c.weights[i] * impulse;
    bool held;
    if (body_of[v] == kNone) {
      held = moving.inverse_mass[v] == 0;
      moving.v[v] += moving.inverse_mass[v] * part;
    } else {
      RigidBody& body = moving.bodies.bodies()[body_of[v]];
      held = body.held;
      if (body.guide) work.external -= part.dot(body.velocity);
      if (!held) {
        const Vec3 torque = (moving.x1[v] - body.center).cross(part);
        body.velocity += part / body.mass;
        body.spin += torque;
        body.angular_velocity += shifts_[body_of[v]].inverse_inertia * torque;
      }
    }
    // External impulses: those of walls, and those that hold fixed vertices and guided bodies.
    const double sign = (c.is_wall() ? 1 : 0) - (held ? 1 : 0);
    work.impulse += sign * part;
    work.angular_impulse += sign * moving.x1[v].cross(part);
  }
  shift(c, c.left * impulse, moving);
}

double ContactForces::solve_normal(ContactConstraint& c, const MovingVertices& moving, ContactWork& work) {
  const double before = c.normal.dot(relative_velocity(c, moving));
  const double sum = std::max(0.0, c.normal_impulse + (c.rebound - before) / c.inverse_mass);
  const double change = sum - c.normal_impulse;
  if (change == 0) return 0;
  c.normal_impulse = sum;
  c.impulse += change * c.normal;
  apply(c, change * c.normal, moving, work);
  work.total -= change * (before + change * c.inverse_mass / 2);
  return std::abs(change) * c.inverse_mass;
}

double ContactForces::solve_friction(ContactConstraint& c, const MovingVertices& moving, ContactWork& work) {
  if (c.friction == 0) return 0;
  const Vec3 velocity = relative_velocity(c, moving);
  const Vec3 slip = velocity - c.normal.dot(velocity) * c.normal;
  const Vec3 so_far = c.impulse - c.normal.dot(c.impulse) * c.normal;
  const double speed = slip.norm();
  Vec3 wanted = so_far;
  if (speed > 0) {
    const double k = inverse_mass(c, slip / speed, moving);
    if (!(k > 0)) return 0;
    wanted -= slip / k;
  }
  const double max = c.friction * c.normal_impulse, size = wanted.norm();
  if (size > max) wanted *= max / size;
  const Vec3 change = wanted - so_far;
  if (change.isZero(0)) return 0;
  c.impulse += change;
  apply(c, change, moving, work);
  const Vec3 after = relative_velocity(c, moving);
  work.total -= change.dot(velocity + after) / 2;
  // The sliding distance of the substep is that up to the contact plus that after it.
  work.friction -= change.dot((1 - c.share) / 2 * (velocity + after) + c.share * after);
  return (after - velocity).norm();
}

void ContactForces::begin_bodies(const MovingVertices& moving) {
  shifts_.resize(moving.bodies.bodies().size());
  for (std::size_t b = 0; b < shifts_.size(); ++b)
    shifts_[b] = {Vec3::Zero(), Vec3::Zero(), moving.bodies.bodies()[b].inverse_inertia_now()};
}

void ContactForces::end_bodies(const MovingVertices& moving) {
  for (std::size_t b = 0; b < shifts_.size(); ++b) {
    RigidBody& body = moving.bodies.bodies()[b];
    body.center += shifts_[b].center;
    body.orientation = turned(body.orientation, shifts_[b].turn);
    if (!shifts_[b].turn.isZero(0)) body.angular_velocity = body.inverse_inertia_now() * body.spin;
  }
  moving.bodies.write_vertices(moving.x1, moving.v);
}

void ContactForces::add(std::span<const ContactConstraint> added, const MovingVertices& moving) {
  begin_bodies(moving);
  std::sort(constraints_.begin(), constraints_.end(), pair_less);
  const std::size_t before = constraints_.size();
  for (const ContactConstraint& from : added) {
    ContactConstraint c = from;
    c.inverse_mass = inverse_mass(c, c.normal, moving);
    if (!(c.inverse_mass > 0)) continue;
    const auto end = constraints_.begin() + static_cast<std::ptrdiff_t>(before);
    const auto there = std::lower_bound(constraints_.begin(), end, c, pair_less);
    if (there == end || !same_pair(*there, c)) {
      const double approach = c.normal.dot(relative_velocity(c, moving));
      if (approach < 0 && c.restitution > 0) c.rebound = -c.restitution * approach;
      constraints_.push_back(c);
      continue;
    }
    c.rebound = std::max(there->rebound, 0.0);
    c.earlier = there->earlier + there->normal_impulse;
    *there = c;
  }
  std::sort(constraints_.begin(), constraints_.end(), time_less);
}

void ContactForces::solve(const MovingVertices& moving, int sweeps, ContactWork& work) {
  if (constraints_.empty()) return;
  begin_bodies(moving);
  double first = 0;
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    double max = 0;
    for (ContactConstraint& c : constraints_)
      max = std::max({max, solve_normal(c, moving, work), solve_friction(c, moving, work)});
    if (sweep == 0) first = max;
    if (max <= kSettled * first) break;
  }
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    double max = 0;
    for (ContactConstraint& c : constraints_) {
      const double lacking = c.goal - gap(c, moving.x1) - c.normal.dot(relative_shift(c, moving));
      if (lacking > 0) shift(c, lacking / c.inverse_mass * c.normal, moving);
      max = std::max(max, lacking);
    }
    if (sweep == 0) first = max;
    if (max <= kSettled * first) break;
  }
  end_bodies(moving);
}

}  // namespace volccd::simulation
