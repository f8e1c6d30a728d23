// A shell mesh with the thickness of its shells, and its solid mesh through edits.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <volccd/mesh/shells.hpp>
#include <volccd/mesh/topology.hpp>

namespace volccd {

/// A mesh whose triangles and quads have a thickness, with the thickener that turns it into a solid mesh. The functions
/// that compute positions use scratch memory of the object: one call at a time.
class ThickenedShells {
 public:
  /// `thickness`, by element slot, in the unit of the coordinates; entries of volumes are not read. Throws InputError
  /// (source "shells", dataset "thickness", slot) if the length is wrong or a value of a shell is negative or not
  /// finite.
  ThickenedShells(Mesh mesh, std::vector<double> thickness);

  const Mesh& mesh() const { return mesh_; }
  Mesh solid_mesh() const { return thickener_.solid_mesh(mesh_); }

  /// ShellThickener::positions for the thickness of this mesh.
  void positions(std::span<const Vec3> x, std::vector<Vec3>& out, Executor& executor) {
    thickener_.positions(x, thickness_, out, scratch_, executor);
  }

  /// This mesh after an edit by slots, which the caller has checked; `thickness` has one value for each added element.
  /// Throws the InputErrors of Mesh and of the constructor. O(elements).
  ThickenedShells edited(const TopologyEdit& edit, std::span<const double> thickness) const;

  /// The edit that turns `solids`, the solid mesh before edits of the shells, into solid_mesh(), except for its slots.
  /// It also replaces solids whose shells have another orientation now. O(elements).
  TopologyEdit edit_of_solids(const Mesh& solids) const;

 private:
  Mesh mesh_;
  std::vector<double> thickness_;  ///< by slot
  ShellThickener thickener_;
  ShellThickener::Scratch scratch_;
};

}  // namespace volccd
