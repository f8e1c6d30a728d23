// Scene `deform`: a made-up motion on any mesh.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <volccd/experiments/scenes/scene.hpp>

namespace volccd {

/// What happens to each copy of the mesh, growing evenly from nothing in the first frame to `amount` in the last. "Long
/// axis": the coordinate axis along which the mesh is longest; "short axis": shortest; both through the centre of its
/// box.
enum class DeformKind {
  /// Turns about the long axis, in proportion to the place along it: `amount` degrees between the two ends. Copies turn
  /// in alternate directions.
  twist,
  /// Bends the long axis into an arc towards the short axis: `amount` degrees between the tangents at its ends. Copies
  /// bend in alternate directions.
  bend,
  /// Shortens along the long axis by the fraction `amount` of the length, and widens across it so that volumes stay.
  squeeze,
  /// Moves each vertex, in each frame but the first anew, by up to `amount` mean edges along each axis. Elements may
  /// turn over.
  jitter,
  /// Moves the copies, as a whole, towards each other along the short axis, until in the last frame each is `amount`
  /// mean edges inside the next. Wants at least two copies.
  collide
};

struct DeformMotion {
  DeformKind kind;
  /// In the unit of its kind. None: what moves the fastest vertex by about one mean edge a step (jitter: 0.3 edges,
  /// whatever the number of steps), but not beyond 180 degrees, half of the length, and 4 edges of depth.
  std::optional<double> amount = {};
};

struct DeformConfig {
  /// Applied one after the other to each copy; collide always comes last. No kind twice.
  std::vector<DeformMotion> motions = {{DeformKind::twist}};
  /// Separate objects, stacked along the short axis with a gap of half a mean edge, each shifted sideways by up to half
  /// an edge at random: in exactly the same pose, vertices would hit vertices.
  int copies = 1;
  int steps = 2;  ///< frames: 2 make one motion
  int seed = 1;   ///< for the shifts and for jitter
};

/// "twist", "twist:60", "twist:60,collide:2". `amount`, where given, is that of the only motion in the list. Throws
/// ConfigError: unknown or repeated kind, not a number, or an amount that could belong to several.
std::vector<DeformMotion> parse_deform_motions(const std::string& text, const std::optional<double>& amount = {});

/// Makes the scene. Copy c of part p (by ascending part id) becomes object c * parts + p. Element ids: those of the
/// mesh in the first copy, continued in the others. Throws ConfigError for a configuration out of range, InputError for
/// a mesh without elements, extent, or finite positions. O(copies * mesh).
std::unique_ptr<Scene> make_deform(const Shape& mesh, const DeformConfig& config = {});

SceneDescriptor describe_deform();

}  // namespace volccd
