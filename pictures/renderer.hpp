// A small software rasteriser: no display, no graphics card, the same bytes everywhere.
#pragma once

#include <span>

#include <volccd/pictures/camera.hpp>
#include <volccd/pictures/image.hpp>
#include <volccd/pictures/surface.hpp>

namespace volccd {

enum class MarkShape { disc, diamond };

/// A mark at a position in the scene. Its size does not depend on its distance from the camera.
struct Mark {
  Vec3 place;
  Colour colour;
  MarkShape shape = MarkShape::disc;
};

struct RenderOptions {
  int samples = 2;          ///< samples^2 samples for each pixel, 1 to 8
  bool edges = false;       ///< thin lines along the elements' edges
  bool lines = true;        ///< outlines, creases, rims
  bool occlusion = true;    ///< corners and gaps are darker
  double line_width = 1.3;  ///< pixels
  double mark_radius = 4;   ///< pixels
  /// Opacity of a mark that lies behind a surface; 0 hides it.
  double hidden_marks = 0.35;
};

/// Draws the surface in these colours (by SurfaceTriangle::colour) on white, then the marks: hidden ones first, then
/// from far to near. There are two lights, which move with the camera. Triangles that are partly behind the camera are
/// left out. Memory: about 10 bytes for each sample and 30 for each pixel. Time: O(triangles + samples).
Image render(const Surface& surface, std::span<const Colour> colours, std::span<const Mark> marks, const Camera& camera,
             int width, int height, const RenderOptions& options = {});

/// Draws a mark on a picture, centred at (x, y): for legends.
void draw_mark(Image& image, double x, double y, double radius, MarkShape shape, Colour colour, double strength = 1);

}  // namespace volccd
