#include <volccd/simulation/contact/contact_response.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include <volccd/core/sort_unique.hpp>

namespace volccd::simulation {
namespace {

/// As fractions of the separation: by how much closer features are pushed apart in a substep, and up to which gap.
constexpr double kPush = 0.02, kPushedTo = 0.5;
/// Gap of features that rest on each other, as a fraction of the separation. It is below 1, because otherwise the
/// elementary tests would have to compare the distance with the separation to the last bit throughout the step.
constexpr double kRest = 0.8;
/// The least gap at the end of a pass, as a fraction of the goal; and how far the gap may be below a negative goal, as
/// a fraction of the separation.
constexpr double kEnough = 0.5, kTolerance = 0.05;
/// Gap that is made between features that would still touch, as a fraction of the separation.
constexpr double kClear = 0.1;
constexpr int kHoldRounds = 10;

}  // namespace

double ContactResponse::goal(const FoundContact& found) const {
  const double d = config_.separation;
  if (!found.at_start) return kRest * d;
  const double max = kPushedTo * d;
  return found.gap0 < max ? std::min(max, found.gap0 + kPush * d) : std::min(found.gap0, kRest * d);
}

ContactConstraint ContactResponse::constraint(const FoundContact& found, double dt,
                                              const MovingVertices& moving) const {
  ContactConstraint c;
  c.kind = found.kind;
  c.features = found.features;
  c.vertices = found.vertices;
  c.weights = found.weights;
  c.normal = found.normal;
  c.toi = found.toi;
  c.share = 1 - found.toi;
  c.left = c.share * dt;
  c.offset = found.gap1 - ContactForces::gap(c, moving.x1);
  c.goal = goal(found);
  const Material& a = bodies_[static_cast<std::size_t>(found.object_a)].material;
  const Material& b = bodies_[static_cast<std::size_t>(found.object_b)].material;
  c.friction = std::min(a.friction, b.friction);
  c.restitution = std::min(a.restitution, b.restitution);
  if (found.at_start && c.restitution == 0) c.rebound = -std::max(0.0, found.gap0 - c.goal) / dt;
  c.solid = found.solid;
  c.contact_class = found.contact_class;
  return c;
}

bool ContactResponse::add_walls(std::span<const Vec3> x0, std::span<const Index> object_of, double dt,
                                const MovingVertices& moving) {
  added_.clear();
  for (std::size_t w = 0; w < walls_.size(); ++w) {
    const Wall& wall = walls_[w];
    const double level = wall.normal.dot(wall.point);
    for (Index v = 0; v < moving.x1.size(); ++v) {
      const double end = wall.normal.dot(moving.x1[v]) - level;
      if (!(end < 0)) continue;
      const double start = wall.normal.dot(x0[v]) - level;
      ContactConstraint c;
      c.features = {kNone, static_cast<Index>(w), v, 0};
      c.vertices = {v, 0, 0, 0};
      c.weights = {1, 0, 0, 0};
      c.size = 1;
      c.normal = wall.normal;
      c.toi = start > 0 ? start / (start - end) : 0;
      c.share = 1 - c.toi;
      c.left = c.share * dt;
      c.offset = -level;
      c.goal = std::min(0.0, start < 0 ? start + kPush * config_.separation : 0.0);
      c.friction = wall.friction;
      c.restitution = bodies_[object_of[v]].material.restitution;
      added_.push_back(c);
    }
  }
  if (added_.empty()) return false;
  forces_.add(added_, moving);
  return true;
}

void ContactResponse::solve(std::span<const Vec3> x0, std::span<const Index> object_of, double dt,
                            const MovingVertices& moving, ContactWork& work) {
  forces_.solve(moving, config_.sweeps, work);
  if (add_walls(x0, object_of, dt, moving)) forces_.solve(moving, config_.sweeps, work);
}

bool ContactResponse::add_found(double dt, bool first, const MovingVertices& moving) {
  added_.clear();
  for (const FoundContact& found : found_) {
    if (found.verdict != ContactVerdict::resist) {
      if (first) ++(found.verdict == ContactVerdict::leaving ? counts_.leaving : counts_.ignored);
      continue;
    }
    const double wanted = goal(found);
    const double enough = wanted > 0 ? kEnough * wanted : wanted - kTolerance * config_.separation;
    if (!first && found.gap1 >= enough) continue;
    added_.push_back(constraint(found, dt, moving));
  }
  if (added_.empty()) return false;
  forces_.add(added_, moving);
  return true;
}

void ContactResponse::substep(std::span<const Vec3> x0, std::span<const Index> object_of, double dt,
                              const MovingVertices& moving, ContactWork& work) {
  forces_.clear();
  bool any = add_walls(x0, object_of, dt, moving);
  for (int pass = 0;; ++pass) {
    find(x0, moving);
    if (pass < config_.passes) any |= add_found(dt, pass == 0, moving);
    if (!any) break;
    solve(x0, object_of, dt, moving, work);
    any = false;
  }
  // Features that slide past each other may touch at other points than those at which the gap was smallest.
  if (!found_.empty()) detection_->keep_touching(found_);
  for (int pass = 0; pass < config_.passes && !found_.empty(); ++pass) {
    added_.clear();
    for (const FoundContact& found : found_) {
      added_.push_back(constraint(found, dt, moving));
      added_.back().goal = kClear * config_.separation;
    }
    forces_.add(added_, moving);
    solve(x0, object_of, dt, moving, work);
    find_touching(x0, moving);
  }
  if (!found_.empty()) hold_apart(x0, moving, work);
  count_pressed();
}

void ContactResponse::find(std::span<const Vec3> x0, const MovingVertices& moving) {
  if (!detection_) return;
  detection_->find(x0, moving.x1, found_);
  ++counts_.queries;
}

void ContactResponse::find_touching(std::span<const Vec3> x0, const MovingVertices& moving) {
  find(x0, moving);
  detection_->keep_touching(found_);
}

void ContactResponse::count_pressed() {
  for (const ContactConstraint& c : forces_.constraints()) {
    if (c.is_wall() || !(c.normal_impulse + c.earlier > 0)) continue;
    ++(c.contact_class == ContactClass::inter   ? counts_.inter
       : c.contact_class == ContactClass::intra ? counts_.intra
                                                : counts_.adjacent);
  }
}

Index ContactResponse::group_of(Index node) {
  while (group_[node] != node) node = group_[node] = group_[group_[node]];
  return node;
}

/// Features that would still touch are moved as groups without rotation, so that no features in a group touch, and get
/// the group's velocity: if they kept their own, forces would accelerate them while they do not move. A group with a
/// guided body moves as that body (of several, or with fixed vertices, features may touch).
void ContactResponse::hold_apart(std::span<const Vec3> x0, const MovingVertices& moving, ContactWork& work) {
  group_.resize(moving.x1.size() + moving.bodies.bodies().size());
  for (Index i = 0; i < group_.size(); ++i) group_[i] = i;
  members_.clear();
  for (int round = 0; round < kHoldRounds; ++round) {
    gather_groups(moving);
    hold_groups(x0, moving, work);
    find_touching(x0, moving);
    if (found_.empty()) break;
  }
  counts_.held += members_.size();
  counts_.unresolved += found_.size();
}

void ContactResponse::gather_groups(const MovingVertices& moving) {
  const std::span<const Index> body_of = moving.bodies.body_of();
  const auto node = [&](Index v) {
    return body_of[v] == kNone ? v : static_cast<Index>(moving.x1.size()) + body_of[v];
  };
  for (const FoundContact& found : found_) {
    const Index first = node(found.vertices[0]);
    for (Index v : found.vertices) {
      members_.push_back(node(v));
      const Index a = group_of(first), b = group_of(node(v));
      group_[std::max(a, b)] = std::min(a, b);
    }
  }
  sort_unique(members_);
}

void ContactResponse::hold_groups(std::span<const Vec3> x0, const MovingVertices& moving, ContactWork& work) {
  std::vector<std::pair<Index, Index>> order;  // (group, member)
  for (Index m : members_) order.emplace_back(group_of(m), m);
  std::sort(order.begin(), order.end());
  std::vector<Index> group;
  for (std::size_t i = 0; i < order.size();) {
    group.clear();
    for (const Index name = order[i].first; i < order.size() && order[i].first == name; ++i)
      group.push_back(order[i].second);
    hold(group, x0, moving, work);
  }
  moving.bodies.write_vertices(moving.x1, moving.v);
}

/// A group that nothing holds keeps its momentum. (Its angular momentum changes, as it does not turn.)
void ContactResponse::hold(std::span<const Index> group, std::span<const Vec3> x0, const MovingVertices& moving,
                           ContactWork& work) {
  const auto vertices = static_cast<Index>(moving.x1.size());
  const auto body = [&](Index m) { return m < vertices ? nullptr : &moving.bodies.bodies()[m - vertices]; };
  const auto mass = [&](Index m) {
    if (const RigidBody* b = body(m)) return b->held ? 0 : b->mass;
    return moving.inverse_mass[m] > 0 ? 1 / moving.inverse_mass[m] : 0;
  };
  bool held = false;
  double sum = 0;
  Vec3 shift = Vec3::Zero(), velocity = Vec3::Zero(), guided_shift = Vec3::Zero(), guided_velocity = Vec3::Zero();
  for (const Index m : group) {
    const RigidBody* b = body(m);
    const Vec3 by = b ? Vec3(b->center - b->marked_center) : Vec3(moving.x1[m] - x0[m]);
    held |= !(mass(m) > 0);
    sum += mass(m);
    shift += mass(m) * by;
    velocity += mass(m) * (b ? b->velocity : moving.v[m]);
    if (b && b->guide) guided_shift = by, guided_velocity = b->velocity;
  }
  shift = held ? guided_shift : Vec3(shift / sum);
  velocity = held ? guided_velocity : Vec3(velocity / sum);
  for (const Index m : group) {
    if (!(mass(m) > 0)) continue;
    RigidBody* b = body(m);
    const Vec3 before = std::exchange(b ? b->velocity : moving.v[m], velocity);
    const Vec3 impulse = mass(m) * (velocity - before);
    work.total -= impulse.dot(before + velocity) / 2;
    if (held) {
      work.total += impulse.dot(velocity);
      work.external += impulse.dot(velocity);
      work.impulse += impulse;
      work.angular_impulse += (b ? b->center : moving.x1[m]).cross(impulse);
    }
    if (!b) {
      moving.x1[m] = x0[m] + shift;
      continue;
    }
    work.total += b->spin.dot(b->angular_velocity) / 2;
    if (held) work.angular_impulse -= b->spin;
    b->spin = b->angular_velocity = Vec3::Zero();
    b->center = b->marked_center + shift;
    b->orientation = b->marked_orientation;
  }
}

}  // namespace volccd::simulation
