#include <volccd/pictures/renderer.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <volccd/core/error.hpp>

namespace volccd {

namespace {

constexpr Colour kWhite{255, 255, 255}, kInk{28, 30, 36};

/// A triangle in the picture's frame, in samples: barycentric weight k at (x, y) is a[k] x + b[k] y + c[k].
struct Setup {
  std::array<double, 3> a, b, c;
  double dx = 0, dy = 0, at = 0;   ///< nearness = dx x + dy y + at
  std::array<double, 3> height{};  ///< of each corner over the opposite edge, in samples
  bool visible = false;

  double weight(int k, double x, double y) const { return a[k] * x + b[k] * y + c[k]; }
  double nearness(double x, double y) const { return dx * x + dy * y + at; }
};

Setup setup_of(const std::array<Camera::Projected, 3>& p) {
  Setup s;
  const double area = (p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[1].y - p[0].y) * (p[2].x - p[0].x);
  if (!(std::abs(area) > 1e-12) || !std::isfinite(area)) return s;
  for (int k = 0; k < 3; ++k) {
    const Camera::Projected &q = p[(k + 1) % 3], &r = p[(k + 2) % 3];
    s.a[k] = (q.y - r.y) / area;
    s.b[k] = (r.x - q.x) / area;
    s.c[k] = (q.x * r.y - q.y * r.x) / area;
    s.height[k] = 1 / std::hypot(s.a[k], s.b[k]);
    s.dx += s.a[k] * p[k].nearness;
    s.dy += s.b[k] * p[k].nearness;
    s.at += s.c[k] * p[k].nearness;
  }
  s.visible = true;
  return s;
}

/// The nearest triangle at each sample, and its nearness.
class Samples {
 public:
  Samples(const Surface& surface, const Camera& camera, int width, int height, int samples)
      : surface_(surface),
        samples_(samples),
        width_(width * samples),
        height_(height * samples),
        triangle_(static_cast<std::size_t>(width_) * height_, kNone),
        nearness_(triangle_.size(), -std::numeric_limits<float>::infinity()) {
    projected_.reserve(surface.points.size());
    for (const Vec3& point : surface.points) {
      Camera::Projected p = camera.project(point);
      p.x *= samples;
      p.y *= samples;
      if (!camera.before(point)) p.x = std::numeric_limits<double>::quiet_NaN();
      projected_.push_back(p);
    }
    for (std::size_t i = 0; i < surface.triangles.size(); ++i) draw(static_cast<Index>(i));
  }

  int width() const { return width_; }
  int height() const { return height_; }
  int samples() const { return samples_; }
  Index triangle(int x, int y) const { return triangle_[offset(x, y)]; }
  /// -infinity if there is no triangle, and outside the picture.
  double nearness(int x, int y) const {
    return x < 0 || y < 0 || x >= width_ || y >= height_ ? -std::numeric_limits<double>::infinity()
                                                         : double{nearness_[offset(x, y)]};
  }
  Setup setup(Index triangle) const { return setup_of(corners(triangle)); }
  std::array<Camera::Projected, 3> corners(Index triangle) const {
    const auto& v = surface_.triangles[triangle].corners;
    return {projected_[v[0]], projected_[v[1]], projected_[v[2]]};
  }

 private:
  std::size_t offset(int x, int y) const { return static_cast<std::size_t>(y) * width_ + x; }

  /// First and last sample between two positions, with samples at half-integers; empty outside the picture.
  static std::pair<int, int> range(double low, double high, int size) {
    return {static_cast<int>(std::ceil(std::clamp(low - 0.5, 0.0, double(size)))),
            static_cast<int>(std::floor(std::clamp(high - 0.5, -1.0, size - 1.0)))};
  }

  void draw(Index triangle) {
    const std::array<Camera::Projected, 3> p = corners(triangle);
    const Setup s = setup_of(p);
    if (!s.visible) return;
    const auto [top, bottom] = range(std::min({p[0].y, p[1].y, p[2].y}), std::max({p[0].y, p[1].y, p[2].y}), height_);
    const auto [left, right] = range(std::min({p[0].x, p[1].x, p[2].x}), std::max({p[0].x, p[1].x, p[2].x}), width_);
    // Samples on a border belong to both neighbours, so that rounding leaves no gaps between them.
    constexpr double kBorder = -1e-9;
    for (int y = top; y <= bottom; ++y) {
      const double v = y + 0.5;
      for (int x = left; x <= right; ++x) {
        const double u = x + 0.5;
        if (s.weight(0, u, v) < kBorder || s.weight(1, u, v) < kBorder || s.weight(2, u, v) < kBorder) continue;
        const auto nearness = static_cast<float>(s.nearness(u, v));
        const std::size_t at = offset(x, y);
        if (nearness <= nearness_[at]) continue;
        nearness_[at] = nearness;
        triangle_[at] = triangle;
      }
    }
  }

  const Surface& surface_;
  int samples_, width_, height_;
  std::vector<Camera::Projected> projected_;  ///< in samples
  std::vector<Index> triangle_;
  std::vector<float> nearness_;
};

/// Unit normal at a sample in the camera frame, towards the viewer; zero for a triangle without area.
Vec3 normal_at(const Surface& surface, const Camera& camera, const Samples& samples, Index triangle, const Setup& s,
               double x, double y, const Vec3& to_viewer) {
  const std::array<Camera::Projected, 3> p = samples.corners(triangle);
  const SurfaceTriangle& t = surface.triangles[triangle];
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < 3; ++k) {
    const double weight = std::max(0.0, s.weight(k, x, y)) * (camera.orthographic() ? 1.0 : p[k].nearness);
    sum += weight * surface.normals[triangle][k].cast<double>();
  }
  const Vec3 own = (surface.points[t.corners[1]] - surface.points[t.corners[0]])
                       .cross(surface.points[t.corners[2]] - surface.points[t.corners[0]]);
  const Vec3 own_in_view = camera.turn(own), in_view = camera.turn(sum);
  const double length = in_view.norm();
  if (!(length > 0)) return Vec3::Zero();
  return (own_in_view.dot(to_viewer) < 0 ? -1 : 1) / length * in_view;
}

/// The share of ambient light that reaches each pixel, which is 1 in the open. It is computed from the depth at
/// positions nearby (after McGuire et al. 2011, "The Alchemy screen-space ambient obscurance algorithm").
class Occlusion {
 public:
  Occlusion(const Surface& surface, const Camera& camera, const Samples& samples)
      : camera_(camera),
        step_(samples.samples()),
        width_(samples.width() / step_),
        height_(samples.height() / step_),
        radius_(0.05 * camera.extent()),
        places_(static_cast<std::size_t>(width_) * height_),
        normals_(places_.size()),
        open_(places_.size(), 1.0f) {
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) look(surface, samples, x, y);
    std::vector<float> raw(open_);
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) raw[offset(x, y)] = gather(x, y);
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) open_[offset(x, y)] = smooth(raw, x, y);
  }

  double at(int x, int y) const { return open_[offset(x, y)]; }

 private:
  std::size_t offset(int x, int y) const { return static_cast<std::size_t>(y) * width_ + x; }
  bool seen(int x, int y) const {
    return x >= 0 && y >= 0 && x < width_ && y < height_ && normals_[offset(x, y)].squaredNorm() > 0;
  }

  void look(const Surface& surface, const Samples& samples, int x, int y) {
    const int column = x * step_ + step_ / 2, row = y * step_ + step_ / 2;
    const Index triangle = samples.triangle(column, row);
    normals_[offset(x, y)].setZero();
    if (triangle == kNone) return;
    const Setup s = samples.setup(triangle);
    const Vec3 place =
        camera_.from_picture((column + 0.5) / step_, (row + 0.5) / step_, s.nearness(column + 0.5, row + 0.5));
    places_[offset(x, y)] = place.cast<float>();
    normals_[offset(x, y)] =
        normal_at(surface, camera_, samples, triangle, s, column + 0.5, row + 0.5, camera_.to_viewer(place))
            .cast<float>();
  }

  /// Positions on a spiral in the unit disc, for each of its kTurns rotations.
  static std::vector<Eigen::Vector2f> spirals() {
    std::vector<Eigen::Vector2f> places;
    for (int turn = 0; turn < kTurns; ++turn)
      for (int i = 0; i < kPlaces; ++i) {
        const double far = std::pow((i + 0.5) / kPlaces, 1.5);
        const double angle = 2 * std::numbers::pi * turn / kTurns + i * 2.399963;
        places.emplace_back(static_cast<float>(far * std::cos(angle)), static_cast<float>(far * std::sin(angle)));
      }
    return places;
  }

  /// The rotation of the spiral varies from pixel to pixel in a pattern of 4 x 4, over which smooth() takes the mean.
  float gather(int x, int y) const {
    if (!seen(x, y)) return 1;
    const Eigen::Vector3f here = places_[offset(x, y)], normal = normals_[offset(x, y)];
    const double pixels = radius_ * camera_.scale(camera_.depth_of(here.cast<double>()));
    const auto reach = static_cast<float>(std::min(pixels, 1e6));
    const auto radius = static_cast<float>(radius_);
    const Eigen::Vector2f* const spiral =
        spirals_.data() + static_cast<std::ptrdiff_t>(((x & 3) * 4 + (y & 3)) * 2 + ((x ^ y) & 1)) * kPlaces;
    float sum = 0;
    for (int i = 0; i < kPlaces; ++i) {
      const int u = static_cast<int>(static_cast<float>(x) + 0.5f + reach * spiral[i].x());
      const int v = static_cast<int>(static_cast<float>(y) + 0.5f + reach * spiral[i].y());
      if ((u == x && v == y) || !seen(u, v)) continue;
      const Eigen::Vector3f d = places_[offset(u, v)] - here;
      const float square = d.squaredNorm(), within = std::max(0.0f, 1 - square / (4 * radius * radius));
      const float above = d.dot(normal) - 0.01f * radius;
      if (above > 0 && square > 0) sum += above / std::sqrt(square) * within;
    }
    return std::max(0.0f, 1 - 1.5f * sum / kPlaces);
  }

  float smooth(const std::vector<float>& raw, int x, int y) const {
    if (!seen(x, y)) return 1;
    double sum = 0, weights = 0;
    const Eigen::Vector3f here = places_[offset(x, y)], normal = normals_[offset(x, y)];
    for (int v = y - 2; v < y + 2; ++v)
      for (int u = x - 2; u < x + 2; ++u) {
        if (!seen(u, v)) continue;
        const double off = std::abs((places_[offset(u, v)] - here).dot(normal)) / (0.2 * radius_);
        const double weight = std::max(0.0, 1 - off) + 1e-3;
        sum += weight * raw[offset(u, v)];
        weights += weight;
      }
    return static_cast<float>(sum / weights);
  }

  static constexpr int kTurns = 32, kPlaces = 18;

  const Camera& camera_;
  int step_, width_, height_;
  double radius_;
  std::vector<Eigen::Vector2f> spirals_ = spirals();
  std::vector<Eigen::Vector3f> places_, normals_;  ///< the normal is zero if there is no triangle
  std::vector<float> open_;
};

/// Colour of each sample.
class Shader {
 public:
  Shader(const Surface& surface, std::span<const Colour> colours, const Camera& camera, const Samples& samples,
         const RenderOptions& options)
      : surface_(surface), colours_(colours), camera_(camera), samples_(samples), options_(options) {}

  /// Red, green, blue from 0 to 255.
  Eigen::Vector3f colour(int x, int y, double open) {
    const Index triangle = samples_.triangle(x, y);
    if (triangle == kNone) return Eigen::Vector3f::Constant(255);
    if (triangle != last_) {
      last_ = triangle;
      setup_ = samples_.setup(triangle);
    }
    const Setup& s = setup_;
    const double u = x + 0.5, v = y + 0.5;
    const SurfaceTriangle& t = surface_.triangles[triangle];
    const Vec3 place = camera_.from_picture(u / samples_.samples(), v / samples_.samples(), s.nearness(u, v));
    const Vec3 to_viewer = camera_.to_viewer(place);
    const Vec3 normal = normal_at(surface_, camera_, samples_, triangle, s, u, v, to_viewer);
    const Colour own = colours_[t.colour];
    Eigen::Vector3f base(own.r, own.g, own.b);
    // A section is paler than the surface, which shows where the body was cut.
    if (t.section) base = 0.72f * base + Eigen::Vector3f::Constant(0.28f * 255);
    Eigen::Vector3f lit = t.section ? Eigen::Vector3f(base * static_cast<float>(0.55 + 0.45 * open))
                                    : light(base, normal, to_viewer, open);
    const float ink = static_cast<float>(line_strength(t, triangle, s, x, y));
    return lit * (1 - ink) + Eigen::Vector3f(kInk.r, kInk.g, kInk.b) * ink;
  }

 private:
  Eigen::Vector3f light(const Eigen::Vector3f& base, const Vec3& normal, const Vec3& to_viewer, double open) const {
    static const Vec3 key = Vec3(-0.5, 0.65, 0.62).normalized(), fill = Vec3(0.85, 0.1, 0.5).normalized();
    const double sky = 0.5 + 0.5 * normal.dot(camera_.up());
    const double around = 0.40 + 0.14 * sky;
    const double direct = 0.45 * std::max(0.0, 0.15 + 0.85 * normal.dot(key)) + 0.16 * std::max(0.0, normal.dot(fill));
    const double shine = std::pow(std::max(0.0, normal.dot((key + to_viewer).normalized())), 40.0);
    const double strength = open * around * 1.05 + direct * (0.35 + 0.65 * open);
    return (base * static_cast<float>(strength) + Eigen::Vector3f::Constant(static_cast<float>(26 * shine * open)))
        .cwiseMin(255.0f);
  }

  double line_strength(const SurfaceTriangle& t, Index triangle, const Setup& s, int x, int y) const {
    double strength = 0;
    const double half = 0.5 * options_.line_width * samples_.samples();
    const double size = *std::max_element(s.height.begin(), s.height.end()) / samples_.samples();
    for (int k = 0; k < 3; ++k) {
      // Edge k lies opposite corner k + 2.
      const int opposite = (k + 2) % 3;
      const double off = std::max(0.0, s.weight(opposite, x + 0.5, y + 0.5)) * s.height[opposite];
      // If elements are hardly larger than a pixel, lines would cover everything.
      if (options_.lines && (t.feature_edges >> k & 1) && off < 0.8 * half)
        strength = std::max(strength, 0.6 * std::clamp((size - 0.7) / 3, 0.12, 1.0));
      if (options_.edges && (t.element_edges >> k & 1) && off < 0.55 * half)
        strength = std::max(strength, 0.42 * std::clamp((size - 1.5) / 5, 0.0, 1.0));
    }
    if (options_.lines && on_outline(t, triangle, s, x, y)) strength = std::max(strength, 0.72);
    return strength;
  }

  /// Whether a neighbouring sample is far behind the plane of this triangle, or has another colour near the plane.
  bool on_outline(const SurfaceTriangle& t, Index triangle, const Setup& s, int x, int y) const {
    const int reach = std::max(1, static_cast<int>(std::lround(0.5 * options_.line_width * samples_.samples())));
    const double here = s.nearness(x + 0.5, y + 0.5), slack = 0.006 * camera_.extent();
    for (const auto& [dx, dy] : {std::pair{reach, 0}, {-reach, 0}, {0, reach}, {0, -reach}}) {
      const double there = samples_.nearness(x + dx, y + dy);
      if (std::isinf(there)) {
        if (x + dx >= 0 && y + dy >= 0 && x + dx < samples_.width() && y + dy < samples_.height()) return true;
        continue;
      }
      const double expected = here + s.dx * dx + s.dy * dy;
      // A plane seen from its side is left within a sample; then only the difference in depth counts.
      const double level = std::min(here, expected > 0 || camera_.orthographic() ? expected : here);
      if (camera_.depth(there) - camera_.depth(level) > slack) return true;
      const Index other = samples_.triangle(x + dx, y + dy);
      if (other != triangle && (surface_.triangles[other].colour != t.colour) && there <= here) return true;
    }
    return false;
  }

  const Surface& surface_;
  std::span<const Colour> colours_;
  const Camera& camera_;
  const Samples& samples_;
  const RenderOptions& options_;
  Index last_ = kNone;  ///< triangle for which setup_ was computed
  Setup setup_{};
};

void draw_marks(Image& image, std::span<const Mark> marks, const Camera& camera, const Samples& samples,
                const RenderOptions& options) {
  struct Placed {
    bool visible;
    double nearness;
    std::size_t mark;
    double x, y;
  };
  std::vector<Placed> placed;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (!camera.before(marks[i].place)) continue;
    const Camera::Projected p = camera.project(marks[i].place);
    if (!(p.x >= 0 && p.y >= 0 && p.x < image.width() && p.y < image.height())) continue;
    // A mark is visible if some sample around it is not in front of it, because samples beside an edge may belong to
    // the background.
    bool visible = false;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const double surface = samples.nearness(static_cast<int>(p.x * samples.samples()) + dx,
                                                static_cast<int>(p.y * samples.samples()) + dy);
        visible = visible || std::isinf(surface) ||
                  camera.depth(p.nearness) - camera.depth(surface) < 0.004 * camera.extent();
      }
    placed.push_back({visible, p.nearness, i, p.x, p.y});
  }
  std::sort(placed.begin(), placed.end(), [](const Placed& a, const Placed& b) {
    return std::tuple(a.visible, a.nearness, a.mark) < std::tuple(b.visible, b.nearness, b.mark);
  });
  for (const Placed& p : placed)
    draw_mark(image, p.x, p.y, options.mark_radius, marks[p.mark].shape, marks[p.mark].colour,
              p.visible ? 1 : options.hidden_marks);
}

}  // namespace

Image render(const Surface& surface, std::span<const Colour> colours, std::span<const Mark> marks, const Camera& camera,
             int width, int height, const RenderOptions& options) {
  if (options.samples < 1 || options.samples > 8)
    throw ConfigError(fmt::format("{} samples a side: there are 1 to 8", options.samples));
  Image image(width, height, kWhite);
  const int n = options.samples;
  const Samples samples(surface, camera, width, height, n);
  const std::unique_ptr<Occlusion> occlusion =
      options.occlusion ? std::make_unique<Occlusion>(surface, camera, samples) : nullptr;
  Shader shader(surface, colours, camera, samples, options);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double open = occlusion ? occlusion->at(x, y) : 1;
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (int i = 0; i < n * n; ++i) sum += shader.colour(x * n + i % n, y * n + i / n, open);
      sum = (sum / static_cast<float>(n * n)).array() + 0.5f;
      image.set(
          x, y,
          {static_cast<std::uint8_t>(sum[0]), static_cast<std::uint8_t>(sum[1]), static_cast<std::uint8_t>(sum[2])});
    }
  draw_marks(image, marks, camera, samples, options);
  return image;
}

void draw_mark(Image& image, double x, double y, double radius, MarkShape shape, Colour colour, double strength) {
  // A white rim separates marks from surfaces of any colour and from each other.
  const double rim = std::max(0.8, 0.28 * radius), reach = radius + rim + 1;
  for (int row = static_cast<int>(y - reach) - 1; row <= static_cast<int>(y + reach) + 1; ++row)
    for (int column = static_cast<int>(x - reach) - 1; column <= static_cast<int>(x + reach) + 1; ++column) {
      const double dx = std::abs(column + 0.5 - x), dy = std::abs(row + 0.5 - y);
      const double off =
          shape == MarkShape::disc ? std::hypot(dx, dy) - radius : (dx + dy - 1.35 * radius) * std::numbers::sqrt2 / 2;
      image.blend(column, row, kWhite, 0.85 * strength * strength * std::clamp(rim + 0.5 - off, 0.0, 1.0));
      image.blend(column, row, colour, strength * std::clamp(0.5 - off, 0.0, 1.0));
    }
}

}  // namespace volccd
