// Where a picture is seen from.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <volccd/mesh/types.hpp>

namespace volccd {

/// Direction and manner of looking, without a place.
struct View {
  /// Degrees. Azimuth turns about the upward axis: 0 looks from the first horizontal axis, 90 from the second.
  /// Elevation 90 looks down from above. Horizontal axes, in this order: up z: x, y; up y: x, -z; up x: y, z.
  double azimuth = -60, elevation = 25;
  char up = 'z';              ///< 'x', 'y' or 'z'
  bool orthographic = false;  ///< else perspective, with `opening` degrees across the larger side
  double opening = 26;
  double zoom = 1;  ///< enlarges about the middle of the picture; the camera stays where it is
};

/// "front", "back", "left", "right" (or "side"), "top", "bottom", "iso", or "azimuth,elevation" in degrees, into
/// `view`. Throws ConfigError for anything else.
void parse_view(const std::string& text, View& view);

/// Unit vector from what is looked at towards the viewer.
Vec3 towards_viewer(const View& view);

/// Maps places to pixels. A value.
class Camera {
 public:
  /// Where a point falls. `nearness` is affine over the picture on any plane of the scene and greater for what is
  /// nearer: 1 / depth in perspective, else -depth. Depth is the distance along the direction of looking.
  struct Projected {
    double x, y, nearness;
  };

  /// A camera such that all `points` (one at least) fall into a picture of this size, less a margin that is this share
  /// of the smaller side. A few passes over the points.
  static Camera fit(std::span<const Vec3> points, const View& view, int width, int height, double margin = 0.03);

  Projected project(const Vec3& point) const;
  /// Perspective: whether the point is far enough before the camera to be drawn.
  bool before(const Vec3& point) const;
  /// Camera frame (x right, y up, z towards the viewer, origin in the target): of a point, and back from the picture.
  Vec3 to_view(const Vec3& point) const { return axes_ * (point - target_); }
  /// Of a direction.
  Vec3 turn(const Vec3& direction) const { return axes_ * direction; }
  double depth_of(const Vec3& in_view) const { return distance_ - in_view.z(); }
  Vec3 from_picture(double x, double y, double nearness) const;
  double depth(double nearness) const { return view_.orthographic ? -nearness : 1 / nearness; }
  /// Pixels that a unit of length takes at this depth.
  double scale(double depth) const { return view_.orthographic ? focal_ : focal_ / depth; }
  /// Unit vector from the point (camera frame) to the camera.
  Vec3 to_viewer(const Vec3& in_view) const;
  /// Upward axis in the camera frame.
  Vec3 up() const { return axes_ * up_; }
  /// Diagonal of what the camera was fitted to.
  double extent() const { return extent_; }
  bool orthographic() const { return view_.orthographic; }

 private:
  Camera(const View& view, int width, int height);
  void approach(std::span<const Vec3> points, double half_width, double half_height);

  View view_;
  double width_, height_;
  Eigen::Matrix3d axes_;  ///< rows: right, up, towards the viewer
  Vec3 up_ = Vec3::UnitZ(), target_ = Vec3::Zero();
  double distance_ = 1;  ///< of the camera from the target
  double focal_ = 1;     ///< pixels a unit (orthographic), or pixels times depth a unit
  double extent_ = 1;
};

/// Height over width of what such a camera sees of the points.
double aspect_of(std::span<const Vec3> points, const View& view);

}  // namespace volccd
