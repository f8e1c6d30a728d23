#include <volccd/pictures/camera.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <volccd/core/error.hpp>

namespace volccd {

namespace {

/// Rows: the two horizontal axes, then the upward one.
Eigen::Matrix3d horizon(char up) {
  Eigen::Matrix3d axes;
  if (up == 'x')
    axes << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  else if (up == 'y')
    axes << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  else
    axes.setIdentity();
  return axes;
}

/// Rows: right, up, towards the viewer. If the view is straight down, the azimuth still determines the horizontal axes.
Eigen::Matrix3d view_axes(const View& view) {
  const double a = view.azimuth * std::numbers::pi / 180, e = view.elevation * std::numbers::pi / 180;
  const Vec3 towards(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
  const Vec3 right(-std::sin(a), std::cos(a), 0);
  Eigen::Matrix3d axes;
  axes.row(0) = right;
  axes.row(1) = towards.cross(right);
  axes.row(2) = towards;
  return axes * horizon(view.up);
}

Eigen::AlignedBox3d bounds(std::span<const Vec3> points, const Eigen::Matrix3d& axes) {
  Eigen::AlignedBox3d box;
  for (const Vec3& p : points) box.extend(Vec3(axes * p));
  return box;
}

bool parse_number(std::string_view text, double& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && std::isfinite(value);
}

}  // namespace

void parse_view(const std::string& text, View& view) {
  static const std::map<std::string, std::pair<double, double>> known = {
      {"front", {-90, 0}}, {"back", {90, 0}},  {"left", {180, 0}},     {"right", {0, 0}},
      {"side", {0, 0}},    {"top", {-90, 90}}, {"bottom", {-90, -90}}, {"iso", {-60, 25}}};
  if (const auto found = known.find(text); found != known.end()) {
    std::tie(view.azimuth, view.elevation) = found->second;
    return;
  }
  const std::size_t comma = text.find(',');
  if (comma == std::string::npos || !parse_number(std::string_view(text).substr(0, comma), view.azimuth) ||
      !parse_number(std::string_view(text).substr(comma + 1), view.elevation) || std::abs(view.elevation) > 90)
    throw ConfigError(
        fmt::format("a view is front, back, left, right, side, top, bottom, iso or AZIMUTH,ELEVATION in degrees "
                    "(elevation -90 to 90), "
                    "not '{}'",
                    text));
}

Vec3 towards_viewer(const View& view) { return view_axes(view).row(2).transpose(); }

Camera::Camera(const View& view, int width, int height)
    : view_(view), width_(width), height_(height), axes_(view_axes(view)), up_(horizon(view.up).row(2).transpose()) {}

Camera Camera::fit(std::span<const Vec3> points, const View& view, int width, int height, double margin) {
  Camera camera(view, width, height);
  const Eigen::AlignedBox3d box = bounds(points, camera.axes_);
  camera.target_ = camera.axes_.transpose() * box.center();
  // A single point has no extent.
  camera.extent_ = box.diagonal().norm() > 0 ? box.diagonal().norm() : 1;
  const double border = margin * std::min(width, height);
  const double half_width = std::max(width / 2.0 - border, 0.5), half_height = std::max(height / 2.0 - border, 0.5);
  if (view.orthographic) {
    const double min = 1e-9 * camera.extent_;
    camera.distance_ = camera.extent_;
    camera.focal_ =
        std::min(2 * half_width / std::max(box.sizes().x(), min), 2 * half_height / std::max(box.sizes().y(), min));
  } else {
    camera.focal_ = std::max(width, height) / 2.0 / std::tan(view.opening * std::numbers::pi / 360);
    for (int pass = 0; pass < 6; ++pass) camera.approach(points, half_width, half_height);
  }
  camera.focal_ *= view.zoom;
  return camera;
}

void Camera::approach(std::span<const Vec3> points, double half_width, double half_height) {
  distance_ = 0;
  double nearest = 0;
  for (const Vec3& point : points) {
    const Vec3 p = to_view(point);
    distance_ = std::max(
        {distance_, p.z() + std::abs(p.x()) * focal_ / half_width, p.z() + std::abs(p.y()) * focal_ / half_height});
    nearest = std::max(nearest, p.z());
  }
  distance_ = std::max(distance_, nearest + 0.02 * extent_);
  Eigen::AlignedBox2d seen;
  for (const Vec3& point : points) {
    const Projected p = project(point);
    seen.extend(Eigen::Vector2d(p.x, p.y));
  }
  const Eigen::Vector2d off = seen.center() - Eigen::Vector2d(width_ / 2, height_ / 2);
  target_ += axes_.transpose() * Vec3(off.x() * distance_ / focal_, -off.y() * distance_ / focal_, 0);
}

Camera::Projected Camera::project(const Vec3& point) const {
  const Vec3 p = to_view(point);
  const double depth = distance_ - p.z(), s = scale(depth);
  return {width_ / 2 + s * p.x(), height_ / 2 - s * p.y(), view_.orthographic ? -depth : 1 / depth};
}

bool Camera::before(const Vec3& point) const {
  return view_.orthographic || distance_ - to_view(point).z() > 0.01 * extent_;
}

Vec3 Camera::from_picture(double x, double y, double nearness) const {
  const double d = depth(nearness), s = scale(d);
  return {(x - width_ / 2) / s, (height_ / 2 - y) / s, distance_ - d};
}

Vec3 Camera::to_viewer(const Vec3& in_view) const {
  if (view_.orthographic) return Vec3::UnitZ();
  return (Vec3(0, 0, distance_) - in_view).normalized();
}

double aspect_of(std::span<const Vec3> points, const View& view) {
  const Camera camera = Camera::fit(points, view, 1000, 1000);
  Eigen::AlignedBox2d seen;
  for (const Vec3& point : points) {
    const Camera::Projected p = camera.project(point);
    seen.extend(Eigen::Vector2d(p.x, p.y));
  }
  return seen.sizes().x() > 0 ? seen.sizes().y() / seen.sizes().x() : 1;
}

}  // namespace volccd
