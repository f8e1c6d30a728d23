// Generated meshes, edits and motions that are difficult for stages which derive the pairs to be tested from the
// topology: a flood, and orphan sources that decide by vertex stars. Coordinates are small integers, so that many
// positions are degenerate and exact arithmetic decides contacts at little cost.
#pragma once

#include <functional>
#include <ostream>
#include <span>
#include <string>
#include <vector>

#include <volccd/oracle/cases/near_degenerate.hpp>
#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/query/motion.hpp>
#include <volccd/query/object_filter.hpp>

namespace volccd::cases {

/// An edit of one of the meshes of a case, and a step that follows it.
struct HostileStep {
  std::size_t mesh = 0;               ///< position in HostileCase::meshes
  std::vector<std::int64_t> removed;  ///< ids of live elements
  Index new_vertices = 0;
  std::vector<ElementSpec> added;  ///< may use the new vertices
  Motion motion;
  double separation = 0, t_max = 1;
  ObjectFilter filter;
  bool first_only = false;  ///< only the earliest contact is requested
  bool initial_overlaps = false;
  std::string what;  ///< short description of the edit and the motion
};

/// Meshes, and steps that are processed in this order with one workspace.
struct HostileCase {
  std::string name;
  std::vector<Mesh> meshes;
  std::vector<HostileStep> steps;
};

/// Part of a case, for which the steps are still to be generated.
struct HostileMesh {
  Shape shape;
  /// Further positions of all vertices, for example with other windings. Steps move the vertices to them, or begin
  /// there.
  std::vector<std::vector<Vec3>> poses;
  std::vector<Index> pulled;                ///< vertices that steps move far, and alone
  std::vector<std::array<Index, 8>> cells;  ///< hexahedral cells that edits divide in another way
  Index moving = 0;                         ///< the vertices from this one on hardly move
  std::string what;
};

struct HostileFamily {
  const char* name;
  HostileMesh (*make)(Choices& choices);
};

inline void PrintTo(const HostileFamily& family, std::ostream* out) { *out << family.name; }

/// The families of generated meshes.
std::span<const HostileFamily> hostile_families();

/// A case with one mesh of this family.
HostileCase make_hostile(Choices& choices, const HostileFamily& family);
/// A case with one or several meshes of any families.
HostileCase make_hostile(Choices& choices);

/// A fixed case of which an earlier version of a stage lost contacts.
struct HostileMember {
  const char* name;
  HostileCase (*make)();
};

inline void PrintTo(const HostileMember& member, std::ostream* out) { *out << member.name; }

std::span<const HostileMember> hostile_members();

/// A case with fewer steps and elements that `fails` still accepts, found by leaving out one part at a time. Pre:
/// fails(c). `fails` must not throw.
HostileCase reduced(HostileCase c, const std::function<bool(const HostileCase&)>& fails);

/// The elements, and all edits and control points of a case, for a report.
std::string to_text(const HostileCase& c);

}  // namespace volccd::cases
