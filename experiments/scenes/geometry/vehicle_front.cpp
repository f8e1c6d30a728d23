#include <volccd/experiments/scenes/geometry/vehicle_front.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

#include <volccd/experiments/scenes/geometry/quad_complex.hpp>

namespace volccd {

namespace {

using Lines = std::vector<double>;

// x of the firewall, of the front end of the floor, and of the rear
constexpr double kFirewall = 1.15, kToe = 1.35, kRear = 1.85;
constexpr double kFloor = 0.30, kSill = 0.54, kRoof = 1.35;
constexpr double kRailIn = 0.38, kRailOut = 0.48, kRailLow = 0.42, kRailMiddle = 0.48, kRailHigh = 0.54;
constexpr double kSide = 0.68, kShelf = 0.60;  // y of the body's side, and of the inner wall of the upper rail
constexpr double kWheelX = 0.62, kWheelZ = 0.30, kWheelIn = 0.52, kWheelOut = 0.70;
// half the side of the square in the middle of a wheel, and radii
constexpr double kHub = 0.10, kRim = 0.19, kTyre = 0.29;
constexpr double kHoodRear = 1.10;
const Lines kStations{0.26, 0.44, 0.52, 0.62, 0.72, 0.80, 0.98, kFirewall};
const Lines kCabY{-kSide, -kShelf, -kRailOut, -kRailIn, kRailIn, kRailOut, kShelf, kSide};

constexpr std::int32_t id(VehiclePart part) { return static_cast<std::int32_t>(part); }

/// A smooth function of x that is 1 at `centre`, and 0 further than `width` / 2 from it.
double bump(double x, double centre, double width) {
  const double c = std::cos(std::numbers::pi * std::clamp((x - centre) / width, -0.5, 0.5));
  return c * c;
}

// Surfaces.

/// How far the middle of a rail's walls is displaced at x: outwards above and below, inwards at the sides. These beads
/// trigger the folds.
double bead(double x) {
  if (x > 0.10 && x < 0.25) return 0.007 * bump(std::fmod(x - 0.10, 0.05), 0.025, 0.05);
  if (x > 0.29 && x < 0.54) return 0.005 * bump(std::fmod(x - 0.29, 0.0627), 0.03135, 0.0627);
  return 0;
}

Vec3 onto_rail(const Vec3& p) {
  if (p.x() > kFirewall - 1e-9) return p;
  const double y0 = (kRailIn + kRailOut) / 2, half_y = (kRailOut - kRailIn) / 2, half_z = (kRailHigh - kRailLow) / 2;
  const double dy = std::abs(p.y()) - y0, dz = p.z() - kRailMiddle;
  const double ry = std::abs(dy) / half_y, rz = std::abs(dz) / half_z;
  Vec3 q = p;
  if (ry >= rz) {
    const double reach = half_y - bead(p.x()) * std::max(0.0, 1 - rz * rz);
    q.y() = std::copysign(y0 + std::copysign(reach, dy), p.y());
  } else {
    q.z() = kRailMiddle + std::copysign(half_z + bead(p.x()) * std::max(0.0, 1 - ry * ry), dz);
  }
  return q;
}

/// Height of the fender's upper edge, just below that of the hood.
double fender_top(double x) { return 0.838 + 0.065 * x; }

double hood_height(double x, double y) { return 0.848 + 0.065 * x + 0.035 * (1 - y * y / (0.66 * 0.66)); }

Vec3 onto_hood(const Vec3& p) { return {p.x(), p.y(), hood_height(p.x(), p.y())}; }

Vec3 onto_fender(const Vec3& p) {
  const double along = std::clamp((p.x() - 0.10) / 0.25, 0.0, 1.0),
               down = std::clamp((fender_top(p.x()) - p.z()) / 0.14, 0.0, 1.0);
  const double out = 0.04 * std::sin(along * std::numbers::pi / 2) * std::sin(down * std::numbers::pi / 2);
  return {p.x(), std::copysign(0.70 + out, p.y()), p.z()};
}

double fascia_x(double y) { return -0.06 + 0.16 * std::pow(y / 0.70, 4); }

Vec3 onto_fascia(const Vec3& p) { return {fascia_x(p.y()), p.y(), p.z()}; }

double toe_height(double x) {
  return kSill + (kFloor - kSill) * std::clamp((x - kFirewall) / (kToe - kFirewall), 0.0, 1.0);
}

Vec3 onto_floor(const Vec3& p) {
  const double tunnel = 0.10 * bump(p.y(), 0, 0.40) * std::clamp((p.x() - kFirewall) / (kToe - kFirewall), 0.0, 1.0);
  return {p.x(), p.y(), toe_height(p.x()) + tunnel};
}

/// Moves points onto an arc about the wheel's axis.
QuadComplex::Snap arc(double radius) {
  return [radius](const Vec3& p) {
    const double dx = p.x() - kWheelX, dz = p.z() - kWheelZ, scale = radius / std::hypot(dx, dz);
    return Vec3(kWheelX + scale * dx, p.y(), kWheelZ + scale * dz);
  };
}

// Parts. One side is described (s = 1: y > 0); the other is symmetric to it.

class Vehicle {
 public:
  Vehicle() {
    body_.snap(id(VehiclePart::crash_boxes), onto_rail);
    body_.snap(id(VehiclePart::rails), onto_rail);
    body_.snap(id(VehiclePart::hood), onto_hood);
    body_.snap(id(VehiclePart::fenders), onto_fender);
    body_.snap(id(VehiclePart::fascia), onto_fascia);
    body_.snap(id(VehiclePart::floor), onto_floor);
    add_bumper();
    for (const double s : {1.0, -1.0}) {
      add_rails(s);
      add_upper_structure(s);
      add_fender(s);
      add_wheel(s);
      add_cab_side(s);
    }
    add_front_panel();
    add_cab();
    add_hood();
    add_fascia();
    add_engine();
  }

  const QuadComplex& body() const { return body_; }

 private:
  using Place = std::function<Vec3(double, double)>;
  void grid(VehiclePart part, const Lines& u, const Lines& v, const Place& place) { body_.grid(id(part), u, v, place); }

  static double beam_x(double y) { return 0.15 * y * y; }

  /// Corners of a section of a rail at x, with three heights.
  static std::vector<Vec3> rail_section(double s, double x, double low, double middle, double high) {
    return {{x, s * kRailIn, low},   {x, s * kRailOut, low}, {x, s * kRailOut, middle},
            {x, s * kRailOut, high}, {x, s * kRailIn, high}, {x, s * kRailIn, middle}};
  }

  void add_bumper() {
    std::vector<std::vector<Vec3>> sections;
    for (const double y : {-0.62, -0.48, -0.38, -0.19, 0.0, 0.19, 0.38, 0.48, 0.62}) {
      const double front = beam_x(y), back = front + 0.06;
      sections.push_back({{front, y, kRailLow},
                          {front, y, kRailHigh},
                          {back, y, kRailHigh},
                          {back, y, kRailMiddle},
                          {back, y, kRailLow}});
    }
    body_.tube(id(VehiclePart::bumper_beam), sections);
  }

  void add_rails(double s) {
    std::vector<Vec3> start = rail_section(s, 0, kRailLow, kRailMiddle, kRailHigh);
    for (Vec3& p : start) p.x() = beam_x(p.y()) + 0.06;
    body_.tube(id(VehiclePart::crash_boxes), {start, rail_section(s, kStations[0], kRailLow, kRailMiddle, kRailHigh)});
    std::vector<std::vector<Vec3>> sections;
    for (const double x : kStations) sections.push_back(rail_section(s, x, kRailLow, kRailMiddle, kRailHigh));
    body_.tube(id(VehiclePart::rails), sections);
    // The part of the firewall below the floor; the floor is the upper wall of the rail there.
    const auto wall = [&](double y, std::pair<double, double> from, std::pair<double, double> to) {
      const auto [z0, z1] = from;
      const auto [z2, z3] = to;
      body_.patch(id(VehiclePart::rails), {kFirewall, y, z0}, {kToe, y, z2}, {kToe, y, z3}, {kFirewall, y, z1});
      body_.patch(id(VehiclePart::rails), {kToe, y, z2}, {kRear, y, z2}, {kRear, y, z3}, {kToe, y, z3});
    };
    for (const double y : {s * kRailIn, s * kRailOut}) {
      wall(y, {kRailLow, kRailMiddle}, {0.20, 0.25});
      wall(y, {kRailMiddle, kRailHigh}, {0.25, kFloor});
    }
    grid(VehiclePart::rails, {kFirewall, kToe, kRear}, {s * kRailIn, s * kRailOut},
         [](double x, double y) { return Vec3(x, y, x < kToe ? kRailLow : 0.20); });
    grid(VehiclePart::rear, {s * kRailIn, s * kRailOut}, {0.20, 0.25, kFloor},
         [](double y, double z) { return Vec3(kRear, y, z); });
  }

  void add_upper_structure(double s) {
    std::vector<std::vector<Vec3>> sections;
    for (const double x : kStations)
      sections.push_back({{x, s * kShelf, 0.72}, {x, s * kSide, 0.72}, {x, s * kSide, 0.80}, {x, s * kShelf, 0.80}});
    body_.tube(id(VehiclePart::upper_rails), sections);
    grid(VehiclePart::aprons, kStations, {kRailHigh, 0.72},
         [s](double x, double z) { return Vec3(x, s * kRailOut, z); });
    grid(VehiclePart::aprons, kStations, {kRailOut, kShelf}, [s](double x, double y) { return Vec3(x, s * y, 0.72); });
    // The sheet that carries the upper edge of the fender.
    grid(VehiclePart::aprons, kStations, {0, 1},
         [s](double x, double t) { return Vec3(x, s * (kSide + t * 0.02), 0.80 + t * (fender_top(x) - 0.80)); });
  }

  void add_fender(double s) {
    constexpr double kArch = 0.34;
    std::vector<Vec3> outline{{0.10, s * 0.70, 0.40}, {0.10, s * 0.70, 0.62}, {0.10, s * 0.70, fender_top(0.10)}};
    for (const double x : kStations) outline.emplace_back(x, s * 0.70, fender_top(x));
    outline.emplace_back(kFirewall, s * 0.70, 0.62);
    outline.emplace_back(kFirewall, s * 0.70, 0.40);
    std::vector<Vec3> arch;
    for (const Vec3& p : outline) arch.push_back(arc(kArch)(p));
    for (std::size_t i = 0; i + 1 < outline.size(); ++i) {
      body_.patch(id(VehiclePart::fenders), arch[i], outline[i], outline[i + 1], arch[i + 1]);
      body_.bend(arch[i], arch[i + 1], arc(kArch));
    }
  }

  /// Eight corners of a loop about the wheel's axis; with radius 0, those of the square core.
  static std::vector<Vec3> wheel_loop(double radius, double y) {
    std::vector<Vec3> loop;
    for (int k = 0; k < 8; ++k) {
      const double angle = k * std::numbers::pi / 4, c = std::cos(angle), d = std::sin(angle);
      const double r = radius > 0 ? radius : kHub / std::max(std::abs(c), std::abs(d));
      loop.emplace_back(kWheelX + r * c, y, kWheelZ + r * d);
    }
    return loop;
  }

  void add_wheel(double s) {
    const std::int32_t wheels = id(VehiclePart::wheels);
    for (const double y : {s * kWheelIn, s * kWheelOut}) {
      const Lines steps{-kHub, 0, kHub};
      grid(VehiclePart::wheels, steps, steps, [y](double x, double z) { return Vec3(kWheelX + x, y, kWheelZ + z); });
      body_.tube(wheels, {wheel_loop(0, y), wheel_loop(kRim, y), wheel_loop(kTyre, y)});
    }
    body_.tube(wheels, {wheel_loop(kTyre, s * kWheelIn), wheel_loop(kTyre, s * kWheelOut)});
    for (const double y : {s * kWheelIn, s * kWheelOut})
      for (const double radius : {kRim, kTyre}) {
        const std::vector<Vec3> loop = wheel_loop(radius, y);
        for (std::size_t k = 0; k < 8; ++k) body_.bend(loop[k], loop[(k + 1) % 8], arc(radius));
      }
    grid(VehiclePart::mounts, {kWheelX - kHub, kWheelX, kWheelX + kHub}, {0, 1}, [s](double x, double t) {
      return Vec3(x, s * (kRailOut + t * (kWheelIn - kRailOut)), kRailLow + t * (kWheelZ + kHub - kRailLow));
    });
  }

  void add_front_panel() {
    const double x = kStations[0];
    const auto place = [x](double y, double z) { return Vec3(x, y, z); };
    const Lines between{-kRailIn, -0.10, 0.10, kRailIn};
    grid(VehiclePart::cross_members, between, {kRailLow, kRailMiddle, kRailHigh}, place);
    grid(VehiclePart::cross_members, {-kShelf, -kRailOut, -kRailIn, -0.10, 0.10, kRailIn, kRailOut, kShelf},
         {0.72, 0.80}, place);
    for (const double s : {1.0, -1.0})
      grid(VehiclePart::cross_members, {s * kRailIn, s * kRailOut}, {kRailLow, kRailMiddle, kRailHigh, 0.72}, place);
    grid(VehiclePart::radiator, between, {kRailHigh, 0.72}, place);
    grid(VehiclePart::cross_members, {kStations[6], kFirewall}, {-kRailIn, kRailIn},
         [](double u, double y) { return Vec3(u, y, kRailLow); });
  }

  /// The sides lean inwards towards the roof.
  static Vec3 cab_point(double x, double y, double z) { return {x, y * (1 - 0.4 * std::max(0.0, z - 0.95)), z}; }

  void add_cab_side(double s) {
    const auto patch = [&](std::array<double, 8> xz) {
      const auto at = [&](std::size_t i) { return cab_point(xz[2 * i], s * kSide, xz[2 * i + 1]); };
      body_.patch(id(VehiclePart::sides), at(0), at(1), at(2), at(3));
    };
    patch({kFirewall, kSill, kToe, kFloor, kRear, kFloor, kRear, kSill});
    for (const auto& [low, high] : {std::pair{kSill, 0.72}, {0.72, 0.80}, {0.80, 0.95}})
      patch({kFirewall, low, kRear, low, kRear, high, kFirewall, high});
    patch({kFirewall, 0.95, kRear, 0.95, kRear, kRoof, 1.60, kRoof});
  }

  void add_cab() {
    grid(VehiclePart::firewall, kCabY, {kSill, 0.72, 0.80, 0.95},
         [](double y, double z) { return Vec3(kFirewall, y, z); });
    grid(VehiclePart::floor, {kFirewall, kToe, kRear}, kCabY,
         [](double x, double y) { return Vec3(x, y, toe_height(x)); });
    grid(VehiclePart::rear, kCabY, {kFloor, kSill, 0.72, 0.80, 0.95, kRoof},
         [](double y, double z) { return cab_point(kRear, y, z); });
    const Lines way{0, 1, 2};  // from the firewall over the windscreen to the rear
    grid(VehiclePart::windscreen, way, kCabY, [](double t, double y) {
      return t < 1 ? cab_point(kFirewall, y, 0.95) : cab_point(t < 2 ? 1.60 : kRear, y, kRoof);
    });
  }

  void add_hood() {
    const Lines ys{-0.66, -kShelf, -kRailOut, -0.10, 0.10, kRailOut, kShelf, 0.66};
    // corners are identified by their position, so that any fixed height will do; the surface determines the final one
    const auto at = [](double x, double y) { return Vec3(x == 0 ? fascia_x(y) + 0.03 : x, y, 0.9); };
    grid(VehiclePart::hood, {0, kStations[0], kHoodRear}, ys, at);
    const auto latch = [&](double y) { return Vec3(kStations[0], y, 0.80); };
    body_.patch(id(VehiclePart::mounts), latch(-0.10), latch(0.10), at(kStations[0], 0.10), at(kStations[0], -0.10));
    for (const double s : {1.0, -1.0})
      body_.patch(id(VehiclePart::mounts), {kFirewall, s * kRailOut, 0.95}, {kFirewall, s * kShelf, 0.95},
                  at(kHoodRear, s * kShelf), at(kHoodRear, s * kRailOut));
  }

  void add_fascia() {
    grid(VehiclePart::fascia, {-0.70, -0.48, -0.24, 0, 0.24, 0.48, 0.70}, {0.40, 0.62, fender_top(0.10)},
         [](double y, double z) { return Vec3(fascia_x(y), y, z); });
  }

  void add_engine() {
    constexpr double kHalf = 0.24, kLow = 0.40, kTop = 0.76;
    const Lines xs{0.40, kWheelX - kHub, kWheelX, kWheelX + kHub, 0.84}, ys{-kHalf, kHalf}, zs{kLow, kRailMiddle, kTop};
    const auto at = [](double x, double y, double z) {  // the engine block is narrower at the top
      const double narrow = z > 0.7 ? 0.75 : 1;
      return Vec3(z > 0.7 ? std::clamp(x, 0.44, 0.80) : x, y * narrow, z);
    };
    for (const double y : {-kHalf, kHalf})
      grid(VehiclePart::engine, xs, zs, [&](double x, double z) { return at(x, y, z); });
    for (const double x : {0.40, 0.84})
      grid(VehiclePart::engine, ys, zs, [&](double y, double z) { return at(x, y, z); });
    for (const double z : {kLow, kTop})
      grid(VehiclePart::engine, xs, ys, [&](double x, double y) { return at(x, y, z); });
    for (const double s : {1.0, -1.0})
      grid(VehiclePart::mounts, {kWheelX - kHub, kWheelX, kWheelX + kHub}, {s * kRailIn, s * kHalf},
           [](double x, double y) { return Vec3(x, y, kRailMiddle); });
  }

  QuadComplex body_;
};

}  // namespace

const char* to_string(VehiclePart part) {
  static constexpr std::array<const char*, kVehicleParts> kNames{
      "bumper beam", "crash boxes", "rails",   "cross members", "radiator", "upper rails",
      "aprons",      "hood",        "fenders", "fascia",        "firewall", "floor",
      "sides",       "windscreen",  "wheels",  "engine",        "mounts",   "rear of the car"};
  return kNames[static_cast<std::size_t>(part)];
}

Shape vehicle_front(int triangles) {
  const Vehicle vehicle;
  return vehicle.body().mesh(vehicle.body().spacing_for(triangles));
}

}  // namespace volccd
