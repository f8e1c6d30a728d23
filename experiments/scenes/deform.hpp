// Scene `deform`: a synthetic motion of any mesh.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <volccd/experiments/scenes/scene.hpp>

namespace volccd {

/// Deformation of each copy of the mesh, which grows linearly from zero in the first frame to `amount` in the last.
/// "Long axis": the coordinate axis along which the mesh is longest; "short axis": shortest; both through the centre of
/// its box.
enum class DeformKind {
  /// Rotates about the long axis by an angle proportional to the position along it: `amount` degrees between the two
  /// ends. Copies turn in alternate directions.
  twist,
  /// Bends the long axis into an arc towards the short axis: `amount` degrees between the tangents at its ends. Copies
  /// bend in alternate directions.
  bend,
  /// Shortens along the long axis by the fraction `amount` of the length, and widens across it so that volumes do not
  /// change.
  squeeze,
  /// Moves each vertex by up to `amount` mean edges along each axis, with new random displacements in each frame but
  /// the first. Elements may invert.
  jitter,
  /// Moves the copies, as a whole, towards each other along the short axis, until in the last frame each is `amount`
  /// mean edges inside the next. Requires at least two copies.
  collide
};

struct DeformMotion {
  DeformKind kind;
  /// In the unit of its kind. If not given, an amount that moves the fastest vertex by about one mean edge in each step
  /// (jitter: 0.3 edges for any number of frames), but at most 180 degrees, half of the length, or 4 edges of depth.
  std::optional<double> amount = {};
};

struct DeformConfig {
  /// Applied one after the other to each copy; collide is always last. Each kind may occur once.
  std::vector<DeformMotion> motions = {{DeformKind::twist}};
  /// Separate objects, stacked along the short axis with a gap of half a mean edge, each shifted sideways at random by
  /// up to half an edge, because without the shifts vertices would hit vertices exactly.
  int copies = 1;
  int frames = 2;  ///< 2 make one step
  int seed = 1;    ///< for the shifts and for jitter
};

/// Parses a text like "twist", "twist:60" or "twist:60,collide:2". `amount`, if given, is that of the only motion in
/// the list. Throws ConfigError for an unknown or repeated kind, a value that is not a number, and an `amount` with
/// several motions.
std::vector<DeformMotion> parse_deform_motions(const std::string& text, const std::optional<double>& amount = {});

/// Makes the scene. Copy c of part p (by ascending part id) becomes object c * parts + p. Element ids in the first copy
/// are those of the mesh; the other copies continue the numbering. Throws ConfigError for a configuration out of range,
/// InputError for a mesh without elements, extent, or finite positions. O(copies * mesh).
std::unique_ptr<Scene> make_deform(const Shape& mesh, const DeformConfig& config = {});

SceneDescriptor describe_deform();

}  // namespace volccd
