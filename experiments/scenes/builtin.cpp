#include <volccd/experiments/scenes/builtin.hpp>

#include <algorithm>
#include <cmath>

#include <volccd/core/error.hpp>
#include <volccd/oracle/cases/portable_functions.hpp>

namespace volccd {

namespace {

const Options<BuiltinConfig>& builtin_options() {
  static const auto options = Options<BuiltinConfig>()
                                  .add("elements", &BuiltinConfig::elements, 100, 10'000'000, "hexahedra, about")
                                  .add("frames", &BuiltinConfig::frames, 2, 100'000, "frames of the sequence");
  return options;
}

// Lengths are in centimetres. The event lasts kDuration units of time; a step takes one unit by default.
constexpr double kDuration = 8;
constexpr double kBlockWidth = 1, kBlockLength = 2.5;  // the block
constexpr double kPlateSide = 8, kPlateThickness = 1.5;
// from the block's leading end to the plate, along the direction of flight
constexpr double kBuiltinGap = 0.3;
constexpr double kSpeed = 0.62, kSlowing = 0.28;  // kSlowing: fraction of the speed that is lost
constexpr double kReach = 1.1;                    // radius, around the path of the block, in which the plate deforms
// distance by which the block has passed an element before the element is removed
constexpr double kDelay = 0.3;

/// The rotation by `z` about the z axis, then by `y` about the y axis.
Eigen::Matrix3d turned(double y, double z) {
  const double cy = portable_cos(y), sy = portable_sin(y), cz = portable_cos(z), sz = portable_sin(z);
  Eigen::Matrix3d axes;
  axes << cy * cz, -cy * sz, sy, sz, cz, 0, -sy * cz, sy * sz, cy;
  return axes;
}

/// m p, summed in this order on every processor, as Eigen's product is not.
Vec3 product(const Eigen::Matrix3d& m, const Vec3& p) {
  const auto row = [&](int i) { return m(i, 0) * p.x() + m(i, 1) * p.y() + m(i, 2) * p.z(); };
  return {row(0), row(1), row(2)};
}

/// The block's rest frame. The origin is the midpoint of its leading end; z points backwards along its path.
struct Flight {
  Eigen::Matrix3d axes = turned(0.21, 0.35);

  Vec3 backwards() const { return axes.col(2); }
  double travel(double time) const { return kSpeed * time * (1 - kSlowing * time / kDuration); }
  /// Midpoint of the leading end. The lowest corner of this end is 0.12 ahead of it along the path.
  Vec3 tip(double time) const { return (kBuiltinGap + 0.12 - travel(time)) * backwards(); }
  /// Distance that the tip has moved since it reached the plate.
  double depth(double time) const { return std::max(0.0, travel(time) - kBuiltinGap); }
};

/// A displacement that keeps faces from being planar.
Vec3 ripple(const Vec3& p, double amount) {
  return amount * Vec3(portable_sin(5.1 * p.y() + 3.3 * p.z()), portable_sin(4.7 * p.z() + 2.9 * p.x()),
                       portable_sin(5.5 * p.x() + 3.7 * p.y()));
}

class Penetration final : public Scene {
 public:
  explicit Penetration(const BuiltinConfig& config) : frames_(config.frames) {
    const double finer = std::cbrt(config.elements / 1530.0);
    const auto cells = [&](int n) { return std::max(1, static_cast<int>(std::lround(n * finer))); };
    Shape shot = block(ElementType::hexahedron, cells(5), cells(5), cells(10));
    Shape plate = block(ElementType::hexahedron, cells(16), cells(16), cells(5));
    fit(shot, Vec3(kBlockWidth, kBlockWidth, kBlockLength), Vec3(0.5, 0.5, 0));
    fit(plate, Vec3(kPlateSide, kPlateSide, kPlateThickness), Vec3(0.5, 0.5, 1));
    shot_vertices_ = shot.positions.size();
    rest_.append(shot, 1).append(plate, 2);
    metadata_.title = "Built-in scene: block penetrating a plate, made up by formula";
    metadata_.source = "volccd scene builtin";
    metadata_.units = "cm";
    metadata_.time_unit = "5 microseconds";
    metadata_.object_names = {{1, "Projectile"}, {2, "Plate"}};
    find_erosion();
  }

  const SequenceMetadata& metadata() const override { return metadata_; }
  int frames() const override { return frames_; }
  double time(int frame) const override { return kDuration * frame / (frames_ - 1); }
  Index vertex_count() const override { return static_cast<Index>(rest_.positions.size()); }

  void positions(int frame, std::vector<Vec3>& out) const override {
    out.resize(rest_.positions.size());
    for (std::size_t v = 0; v < out.size(); ++v)
      out[v] = v < shot_vertices_ ? shot_point(rest_.positions[v], time(frame))
                                  : plate_point(rest_.positions[v], time(frame));
  }

  void cells(int frame, SequenceCells& out) const override {
    out.clear();
    for (std::size_t i = 0; i < rest_.elements.size(); ++i)
      if (frame < erodes_at_[i]) out.add(rest_.elements[i]);
  }

 private:
  /// Scales the shape to `size`, and moves the point at the fractions `origin` of its extent to the origin.
  static void fit(Shape& shape, const Vec3& size, const Vec3& origin) {
    Vec3 extent = Vec3::Zero();
    for (const Vec3& p : shape.positions) extent = extent.cwiseMax(p);
    for (Vec3& p : shape.positions) p = (p.cwiseQuotient(extent) - origin).cwiseProduct(size);
  }

  /// The leading end is upset: it is compressed along the path and spreads.
  Vec3 shot_point(const Vec3& p, double t) const {
    const double upset = 0.4 * std::min(1.0, flight_.depth(t) / 2) * portable_exp(-p.z() / 0.6);
    Vec3 local(p.x() * (1 + 0.6 * upset), p.y() * (1 + 0.6 * upset), p.z() + upset);
    local += ripple(p, 0.008 + 0.012 * std::min(1.0, flight_.depth(t)));
    return flight_.tip(t) + product(flight_.axes, local);
  }

  /// The plate is dented and pushed aside around the path of the block.
  Vec3 plate_point(const Vec3& p, double t) const {
    const double depth = flight_.depth(t);
    const Vec3 way = flight_.backwards();
    const Vec3 aside = p - way * (p.z() / way.z());
    const double r = portable_hypot(aside.x(), aside.y()) / kReach;
    const double near = portable_exp(-r * r) * std::min(1.0, depth / kPlateThickness);
    const Vec3 pushed(0.3 * near * aside.x(), 0.3 * near * aside.y(), -0.45 * near);
    return p + pushed + ripple(p, 0.01 + 0.02 * near);
  }

  bool is_eroded(std::size_t element, double t) const {
    Vec3 centre = Vec3::Zero();
    for (const Index v : rest_.elements[element].vertices) centre += rest_.positions[v] / 8;
    const double depth = flight_.depth(t);
    if (rest_.elements[element].object == 1)
      return centre.z() < 0.35 * (depth - 0.9) - 0.3 * std::abs(portable_hypot(centre.x(), centre.y()) - 0.4);
    const Vec3 local = product(flight_.axes.transpose(), plate_point(centre, t) - flight_.tip(t));
    return local.z() > kDelay && std::max(std::abs(local.x()), std::abs(local.y())) < kBlockWidth / 2 + 0.1;
  }

  void find_erosion() {
    erodes_at_.assign(rest_.elements.size(), frames_);
    for (std::size_t i = 0; i < rest_.elements.size(); ++i)
      for (int frame = 1; frame < frames_ && erodes_at_[i] == frames_; ++frame)
        if (is_eroded(i, time(frame))) erodes_at_[i] = frame;
  }

  int frames_;
  Flight flight_;
  Shape rest_;
  std::size_t shot_vertices_ = 0;
  std::vector<int> erodes_at_;  ///< first frame without the element
  SequenceMetadata metadata_;
};

}  // namespace

std::unique_ptr<Scene> make_builtin(const BuiltinConfig& config) {
  if (config.elements < 100 || config.elements > 10'000'000)
    throw ConfigError("builtin: elements is not in 100 .. 10000000");
  if (config.frames < 2 || config.frames > 100'000) throw ConfigError("builtin: frames is not in 2 .. 100000");
  return std::make_unique<Penetration>(config);
}

SceneDescriptor describe_builtin() {
  return {"builtin", "a block of hexahedra goes through a plate, by formula; elements erode; needs no data", false,
          builtin_options().describe(),
          [](const OptionValues& values, const Shape*) { return make_builtin(builtin_options().parse(values)); }};
}

}  // namespace volccd
