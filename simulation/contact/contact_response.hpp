// Alternates contact detection and response until a substep ends without penetration.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <volccd/simulation/contact/contact_detection.hpp>
#include <volccd/simulation/contact/contact_forces.hpp>
#include <volccd/simulation/model.hpp>

namespace volccd::simulation {

struct ContactCounts {
  std::uint64_t queries = 0, inter = 0, intra = 0, adjacent = 0, leaving = 0, ignored = 0, held = 0, unresolved = 0;
};

class ContactResponse {
 public:
  struct Config {
    int passes = 4, sweeps = 12;
    double separation = 0;
  };

  /// `detection`: null if only walls act. `bodies` and `walls` must outlive this object.
  ContactResponse(std::unique_ptr<ContactDetection> detection, std::span<const Body> bodies,
                  std::span<const Wall> walls, Config config)
      : config_(config), detection_(std::move(detection)), bodies_(bodies), walls_(walls) {}

  ContactDetection* detection() { return detection_.get(); }

  /// Resolves the contacts of a substep of length dt from the positions `x0`, where RigidBodies::mark() was called;
  /// afterwards no two features touch, except for the pairs that counts().unresolved counts. `object_of`: body by
  /// vertex, for walls.
  void substep(std::span<const Vec3> x0, std::span<const Index> object_of, double dt, const MovingVertices& moving,
               ContactWork& work);

  /// The constraints of the last substep.
  const std::vector<ContactConstraint>& constraints() const { return forces_.constraints(); }
  ContactCounts& counts() { return counts_; }

 private:
  bool add_walls(std::span<const Vec3> x0, std::span<const Index> object_of, double dt, const MovingVertices& moving);
  void solve(std::span<const Vec3> x0, std::span<const Index> object_of, double dt, const MovingVertices& moving,
             ContactWork& work);
  void find(std::span<const Vec3> x0, const MovingVertices& moving);
  void find_touching(std::span<const Vec3> x0, const MovingVertices& moving);
  bool add_found(double dt, bool first, const MovingVertices& moving);
  ContactConstraint constraint(const FoundContact& found, double dt, const MovingVertices& moving) const;
  double goal(const FoundContact& found) const;
  void hold_apart(std::span<const Vec3> x0, const MovingVertices& moving, ContactWork& work);
  void gather_groups(const MovingVertices& moving);
  void hold_groups(std::span<const Vec3> x0, const MovingVertices& moving, ContactWork& work);
  void hold(std::span<const Index> group, std::span<const Vec3> x0, const MovingVertices& moving, ContactWork& work);
  Index group_of(Index node);
  void count_pressed();

  Config config_;
  std::unique_ptr<ContactDetection> detection_;
  std::span<const Body> bodies_;
  std::span<const Wall> walls_;
  ContactForces forces_;
  ContactCounts counts_;
  std::vector<FoundContact> found_;
  std::vector<ContactConstraint> added_;
  /// Used by hold_apart(): groups of vertices and rigid bodies (union-find; bodies follow the vertices), and the
  /// members of all groups.
  std::vector<Index> group_, members_;
};

}  // namespace volccd::simulation
