// Decides the direction of a contact, and whether it is resisted.
#pragma once

#include <span>

#include <volccd/mesh/topology.hpp>
#include <volccd/query/contact.hpp>
#include <volccd/query/motion.hpp>
#include <volccd/simulation/contact/contact_surface.hpp>
#include <volccd/simulation/contact/found_contact.hpp>

namespace volccd::simulation {

/// Refers to one motion. The side on which a feature should lie is taken from the outward side for features on the
/// surface, from the shape at rest for features of one element, and from the centroids of elements or objects for
/// interior features. A contact is ignored if another pair of features is nearer at that point (beyond a triangle's
/// border, at an edge's end), and if it is close to two copies of a split vertex that have not yet moved apart.
/// Thread-safe.
class ContactJudge {
 public:
  struct Scene {
    const Topology& topology;  ///< of the collision mesh
    const Motion& motion;
    const ContactSurface& surface;
    std::span<const Vec3> reference;  ///< positions at rest, by vertex of the simulated mesh
    std::span<const Vec3> middles;    ///< centroids of objects, at the start
    Index copies;                     ///< as in ContactSurface
    bool adjacent;                    ///< whether adjacent elements resist each other
    double separation;
  };
  explicit ContactJudge(const Scene& scene) : s_(scene) {}

  FoundContact describe(const Contact& contact) const;

 private:
  void judge(const Contact& contact, FoundContact& found) const;
  Vec3 outward(std::span<const Index> elements, const Vec3& point) const;
  Vec3 made_up_normal(const Contact& contact) const;
  int side_in_reference(const FoundContact& found) const;
  bool faces(Index v0, Index v1, const Vec3& normal, double toi, bool boundary_only) const;
  bool faces(Index vertex, const Vec3& normal, double toi) const;
  bool rim_faces(const Contact& contact) const;
  bool at_twins(const Contact& contact) const;
  void judge_triangle(const Contact& contact, FoundContact& found, std::span<const Index> elements) const;
  void judge_edges(const Contact& contact, FoundContact& found, std::span<const Index> a,
                   std::span<const Index> b) const;
  bool comes_out(const FoundContact& found, std::span<const Index> a, std::span<const Index> b) const;

  const Scene s_;
};

}  // namespace volccd::simulation
