// The camera of a picture: view direction, position, and projection.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <volccd/numerics/types.hpp>

namespace volccd {

/// View direction and kind of projection, without a position.
struct View {
  /// In degrees. Azimuth is the angle about the upward axis: at 0 the viewer is on the first horizontal axis, at 90 on
  /// the second. At elevation 90 the viewer looks down from above. The horizontal axes are, in this order, x, y if z is
  /// up; x, -z if y is up; y, z if x is up.
  double azimuth = -60, elevation = 25;
  char up = 'z';              ///< 'x', 'y' or 'z'
  bool orthographic = false;  ///< else perspective, with `opening` degrees across the larger side
  double opening = 26;
  double zoom = 1;  ///< magnification about the middle of the picture; the camera does not move
};

/// Sets `view` from "front", "back", "left", "right" (or "side"), "top", "bottom", "iso", or "azimuth,elevation" in
/// degrees. Throws ConfigError for any other text.
void parse_view(const std::string& text, View& view);

/// Unit vector from the scene towards the viewer.
Vec3 towards_viewer(const View& view);

/// Maps points of the scene to pixels. Copyable.
class Camera {
 public:
  /// The image of a point. `nearness` is greater for nearer points, and an affine function of x and y on any plane of
  /// the scene: 1 / depth in perspective, else -depth. Depth is the distance along the view direction.
  struct Projected {
    double x, y, nearness;
  };

  /// A camera such that the images of all `points` (at least one) lie inside a picture of this size, with a margin
  /// given as a fraction of the smaller side. O(points).
  static Camera fit(std::span<const Vec3> points, const View& view, int width, int height, double margin = 0.03);

  Projected project(const Vec3& point) const;
  /// Whether the point is far enough in front of the camera to be drawn (always true if orthographic).
  bool before(const Vec3& point) const;
  /// Coordinates of a point in the camera frame (x right, y up, z towards the viewer, origin in the target).
  /// from_picture() gives them for a projected point.
  Vec3 to_view(const Vec3& point) const { return axes_ * (point - target_); }
  /// Coordinates of a direction in the camera frame.
  Vec3 turn(const Vec3& direction) const { return axes_ * direction; }
  double depth_of(const Vec3& in_view) const { return distance_ - in_view.z(); }
  Vec3 from_picture(double x, double y, double nearness) const;
  double depth(double nearness) const { return view_.orthographic ? -nearness : 1 / nearness; }
  /// Pixels per unit of length at this depth.
  double scale(double depth) const { return view_.orthographic ? focal_ : focal_ / depth; }
  /// Unit vector from the point (camera frame) to the camera.
  Vec3 to_viewer(const Vec3& in_view) const;
  /// Upward axis in the camera frame.
  Vec3 up() const { return axes_ * up_; }
  /// Diagonal of the bounding box of the points to which the camera was fitted.
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
  double focal_ = 1;     ///< pixels per unit (orthographic), or pixels times depth per unit
  double extent_ = 1;
};

/// Height over width of the image of the points with such a camera.
double aspect_of(std::span<const Vec3> points, const View& view);

}  // namespace volccd
