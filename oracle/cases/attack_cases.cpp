#include <volccd/oracle/cases/attack_cases.hpp>

#include <algorithm>
#include <cmath>

#include <volccd/oracle/cases/contact_builder.hpp>

namespace volccd::cases {
namespace {

/// A number in [2^low, 2^(high + 1)) with 20 bits, distributed over the powers of two.
double magnitude(Choices& c, int low, int high) {
  return std::ldexp(1 + c.below(1 << 20) * 0x1p-20, low + c.below(high - low + 1));
}

using Magnitude = double (*)(Choices&);

double skewed_length(Choices& c) { return magnitude(c, -9, 4); }
/// A number that uses all bits of a double.
double denormal_length(Choices& c) { return c.below(1 << c.below(12)) * 0x1p-1074; }
double any_length(Choices& c) {
  switch (c.below(5)) {
    case 0: return magnitude(c, -1, 1);
    case 1: return magnitude(c, -997, -996);  // 1e-300
    case 2: return magnitude(c, 996, 997);    // 1e300
    case 3: return denormal_length(c);
    default: return magnitude(c, -60, 60);
  }
}
/// Magnitudes of which some differences overflow.
double great_length(Choices& c) { return c.one_in(4) ? magnitude(c, -30, 30) : magnitude(c, 1021, 1023); }

Vec3 three(Choices& c, Magnitude of) { return {of(c), of(c), of(c)}; }

/// Heights that change their sign. For most of them this is certain, because those at the ends are opposite.
Vec3 heights(Choices& c, int control_points, Magnitude of) {
  Vec3 z = three(c, of);
  const bool opposite = !c.one_in(6);
  z[control_points - 1] *= opposite ? -1 : 1;
  if (control_points == 3) z[1] *= c.below(2) ? -1 : 1;
  return c.below(2) ? Vec3(-z) : z;
}

void turn_axes(Choices& c, Case& made) {
  const int turn = c.below(3), flip = c.below(8);
  for (auto& set : made.sets)
    for (Curve& p : set)
      for (Vec3& x : p) {
        const Vec3 y = x;
        for (int k = 0; k < 3; ++k) x[k] = (flip >> k & 1) ? -y[(k + turn) % 3] : y[(k + turn) % 3];
      }
}

/// Crossing features of such magnitudes, perhaps with a different width and height for each point.
Case frame(Choices& c, FeatureKind kind, int control_points, Magnitude of) {
  const Vec3 p = three(c, of), q = three(c, of), z = heights(c, control_points, of);
  const double first = z[0], last = z[control_points - 1];
  Case made = crossing_frame(kind, control_points, p, q, z);
  made.touch = (first <= 0 && last >= 0) || (first >= 0 && last <= 0) ? 1 : -1;
  if (c.one_in(3))
    for (auto& set : made.sets)
      for (Curve& point : set)
        for (int axis = 0; axis < 3; ++axis) {
          const Vec3 by = three(c, of);
          for (std::size_t k = 0; k < 3; ++k)
            point[k][axis] = std::copysign(point[k][axis] == 0 ? 0 : by[static_cast<int>(k)], point[k][axis]);
        }
  if (control_points == 2)
    for (auto& set : made.sets)
      for (Curve& point : set) point[2] = point[1];
  turn_axes(c, made);
  return made;
}

Case general(Choices& c, FeatureKind kind, int control_points) {
  ContactBuilder builder(c, kind, control_points);
  builder.features(ContactBuilder::Shape::general);
  builder.transform();
  builder.reorder();
  return builder.build();
}

Case degenerate(Choices& c, FeatureKind kind, int control_points) {
  ContactBuilder builder(c, kind, control_points);
  builder.features(ContactBuilder::Shape::degenerate);
  builder.transform();
  builder.reorder();
  return builder.build();
}

/// Half of the cases are in general position.
void any_or_general(Choices& c, ContactBuilder& builder) {
  builder.features(c.below(2) ? ContactBuilder::Shape::any : ContactBuilder::Shape::general);
}

Case at_an_end(Choices& c, FeatureKind kind, int control_points) {
  ContactBuilder builder(c, kind, control_points, c.below(2));
  any_or_general(c, builder);
  builder.transform();
  builder.reorder();
  return builder.build();
}

/// All points have the same motion, so that the features touch at the start or never.
Case rigid(Choices& c, FeatureKind kind, int control_points) {
  ContactBuilder builder(c, kind, control_points, 0);
  any_or_general(c, builder);
  Vec3 by[3] = {Vec3::Zero(), {}, {}};
  for (int k = 1; k < 3; ++k) by[k] = Vec3(c.lattice(1 << 18), c.lattice(1 << 18), c.lattice(1 << 18));
  for (auto& set : builder.made().sets)
    for (Curve& p : set)
      for (std::size_t k = 1; k < 3; ++k) p[k] = p[0] + by[control_points == 2 ? 1 : k];
  if (c.one_in(3)) builder.nudge();
  builder.reorder();
  return builder.build();
}

Case near_miss(Choices& c, FeatureKind kind, int control_points) {
  ContactBuilder builder(c, kind, control_points);
  any_or_general(c, builder);
  builder.transform();
  if (c.one_in(3)) builder.scale();
  builder.nudge();
  builder.reorder();
  return builder.build();
}

Case far_off(Choices& c, FeatureKind kind, int control_points) {
  ContactBuilder builder(c, kind, control_points);
  builder.features(c.below(2) ? ContactBuilder::Shape::degenerate : ContactBuilder::Shape::any);
  builder.move_far();
  if (c.below(2)) builder.nudge();
  builder.reorder();
  return builder.build();
}

/// Multiples of the smallest double. The builder makes multiples of 2^-10.
void make_denormal(Choices& c, ContactBuilder& builder) {
  const int below_exact = c.below(12);
  builder.scale_by(Vec3::Constant(0x1p-1000));
  builder.scale_by(Vec3::Constant(std::ldexp(1, -64 - below_exact)));
  if (below_exact > 0) builder.made().touch = -1;
}

Case denormal(Choices& c, FeatureKind kind, int control_points) {
  if (c.below(2)) return frame(c, kind, control_points, denormal_length);
  ContactBuilder builder(c, kind, control_points);
  any_or_general(c, builder);
  make_denormal(c, builder);
  builder.reorder();
  return builder.build();
}

Case mixed_scales(Choices& c, FeatureKind kind, int control_points) {
  if (c.below(2)) return frame(c, kind, control_points, any_length);
  ContactBuilder builder(c, kind, control_points);
  any_or_general(c, builder);
  Vec3 by;
  for (double& factor : by) factor = c.pick({1, 0x1p-996, 0x1p950, 0x1p-1022, 0x1p-500});
  builder.scale_by(by);
  builder.reorder();
  return builder.build();
}

/// Coordinates up to the greatest double along one axis or all axes, so that differences overflow.
void make_greatest(Choices& c, ContactBuilder& builder) {
  Vec3 max = Vec3::Constant(builder.made().separation), by = Vec3::Ones();
  for (const auto& set : builder.made().sets)
    for (const Curve& p : set)
      for (const Vec3& x : p) max = max.cwiseMax(x.cwiseAbs());
  const bool all = c.below(2) || builder.made().separation > 0;
  const int axis = c.below(3);
  for (int k = 0; k < 3; ++k) {
    const double greatest = all ? max.maxCoeff() : max[k];
    if (greatest > 0 && (all || k == axis || c.one_in(4)))
      by[k] = std::ldexp(1, std::min(1023, 1023 - std::ilogb(greatest)));
  }
  builder.scale_by(by);
}

/// Features on one line that may overlap along it; coordinates are fractions of the greatest double, or 0. VF: the
/// vertex and a side of the triangle are on the line; EE: the first edge is on it, and the second one crosses it.
/// `still`: one point moves; otherwise all points may move and pass through the line.
Case great_line(Choices& c, FeatureKind kind, int control_points, bool still) {
  const bool passing = !still && c.below(2);
  const Vec3 height = passing ? heights(c, control_points, skewed_length) : Vec3(Vec3::Zero());
  int points = 0;
  const auto point = [&](double y, bool lifted) {
    Curve p;
    for (std::size_t k = 0; k < 3; ++k)
      p[k] = {0x1p1023 * c.pick({0, -1.9375, 1.9375, -1.75, 1.75, -1.5, 1.5}), y,
              lifted ? height[static_cast<int>(k)] : 0};
    const bool moves = still ? points == 1 : c.below(2) != 0;
    ++points;
    if (!moves) p[1].x() = p[2].x() = p[0].x();
    if (control_points == 2) p[2] = p[1];
    return p;
  };
  Case made;
  made.kind = kind;
  made.control_points = control_points;
  if (kind == FeatureKind::vf) {
    made.sets[0] = {point(0, true)};
    made.sets[1] = {point(0, false), point(0, false), point(1, false)};
  } else {
    made.sets[0] = {point(0, true), point(0, true)};
    const Curve below = point(-1, false);
    Curve above = below;
    for (Vec3& x : above) x.y() = 1;
    made.sets[1] = {below, above};
  }
  turn_axes(c, made);
  return made;
}

Case overflow(Choices& c, FeatureKind kind, int control_points) {
  const int how = c.below(4);
  if (how == 1) return frame(c, kind, control_points, great_length);
  if (how >= 2) return great_line(c, kind, control_points, how == 2);
  ContactBuilder builder(c, kind, control_points);
  any_or_general(c, builder);
  make_greatest(c, builder);
  builder.reorder();
  return builder.build();
}

/// Smooth motion whose coplanarity polynomial is nearly constant for most of the step, so that Newton's method leaves
/// the step from its initial point. Random motions are hardly ever like this. Therefore these motions are fixed, with
/// small changes of every control value.
constexpr double kFlat[][9] = {{.069, .0161, 1.13, .499, .00357, .00285, -11, .0785, .064},
                               {.0057, .0069, .66, 1.7, .28, .12, -.034, -.042, 5.8}};

Case flat(Choices& c, FeatureKind kind, int control_points) {
  double values[9];
  const auto& from = kFlat[c.below(2)];
  const double change = std::ldexp(1, -3 - c.below(10)) / 1024;
  for (int i = 0; i < 9; ++i) values[i] = from[i] * (1 + change * c.lattice(1024));
  const auto at = [&](int i) { return Vec3(values[i], values[i + 1], values[i + 2]); };
  Case made = crossing_frame(kind, control_points, at(0), at(3), at(6));
  made.touch = control_points == 3 ? 1 : -1;
  turn_axes(c, made);
  return made;
}

Case skewed(Choices& c, FeatureKind kind, int control_points) {
  return c.below(2) ? flat(c, kind, control_points) : frame(c, kind, control_points, skewed_length);
}

/// The first set is moved away by exactly the separation; then the separation may be changed by a few units in the last
/// place.
Case at_the_separation(Choices& c, FeatureKind kind, int control_points) {
  ContactBuilder builder(c, kind, control_points);
  any_or_general(c, builder);
  builder.move_apart();
  builder.transform();
  builder.reorder();
  Case made = builder.build();
  const int units = static_cast<int>(c.lattice(3));
  for (int i = 0; i < std::abs(units); ++i) made.separation = std::nextafter(made.separation, units > 0 ? HUGE_VAL : 0);
  if (units < 0) made.touch = -1;
  return made;
}

Case at_the_separation_at_an_end(Choices& c, FeatureKind kind, int control_points) {
  ContactBuilder builder(c, kind, control_points, c.below(2));
  any_or_general(c, builder);
  builder.move_apart();
  builder.transform();
  builder.reorder();
  return builder.build();
}

Case nearly_at_the_separation(Choices& c, FeatureKind kind, int control_points) {
  ContactBuilder builder(c, kind, control_points);
  any_or_general(c, builder);
  builder.move_apart();
  builder.transform();
  c.below(2) ? builder.nudge() : builder.move_far();
  builder.reorder();
  return builder.build();
}

Case scaled_separation(Choices& c, FeatureKind kind, int control_points) {
  ContactBuilder builder(c, kind, control_points);
  any_or_general(c, builder);
  builder.move_apart();
  c.below(2) ? make_greatest(c, builder) : make_denormal(c, builder);
  builder.reorder();
  return builder.build();
}

Case frame_and_separation(Choices& c, FeatureKind kind, int control_points) {
  Case made = frame(c, kind, control_points, skewed_length);
  made.separation = magnitude(c, -12, 3);
  return made;
}

constexpr Attack kTouching[] = {{"General", 2000, general},   {"Degenerate", 800, degenerate},
                                {"AtAnEnd", 800, at_an_end},  {"Rigid", 800, rigid},
                                {"NearMiss", 800, near_miss}, {"FarOff", 800, far_off},
                                {"Denormal", 800, denormal},  {"MixedScales", 60, mixed_scales},
                                {"Overflow", 800, overflow},  {"Skewed", 10'000, skewed}};
constexpr Attack kSeparated[] = {{"AtTheSeparation", 500, at_the_separation},
                                 {"AtTheSeparationAtAnEnd", 500, at_the_separation_at_an_end},
                                 {"NearlyAtTheSeparation", 500, nearly_at_the_separation},
                                 {"ScaledSeparation", 500, scaled_separation},
                                 {"FrameAndSeparation", 2000, frame_and_separation}};

}  // namespace

std::span<const Attack> touching_attacks() { return kTouching; }
std::span<const Attack> separation_attacks() { return kSeparated; }

Case attack_test(Choices& choices, const Attack& attack) {
  const FeatureKind kind = choices.below(2) ? FeatureKind::ee : FeatureKind::vf;
  return attack.make(choices, kind, 2 + choices.below(2));
}

Case any_attack_test(Choices& choices, std::span<const Attack> attacks) {
  return attack_test(choices, attacks[static_cast<std::size_t>(choices.below(static_cast<int>(attacks.size())))]);
}

Case any_attack_elements(Choices& choices, std::span<const Attack> attacks, FeatureKind kind, int control_points,
                         std::size_t count) {
  const auto which = static_cast<std::size_t>(choices.below(static_cast<int>(attacks.size())));
  Case made = attacks[which].make(choices, kind, control_points);
  const auto any_point = [&]() -> const Curve& {
    const auto& set = made.sets[static_cast<std::size_t>(choices.below(2))];
    return set[static_cast<std::size_t>(choices.below(static_cast<int>(made.own(&set == &made.sets[1]))))];
  };
  for (auto& set : made.sets)
    while (set.size() < count) {
      Curve p;
      for (int axis = 0; axis < 3; ++axis) {
        const Curve& from = any_point();
        const int sign = choices.one_in(4) ? -1 : 1;
        for (std::size_t k = 0; k < 3; ++k) p[k][axis] = sign * from[k][axis];
      }
      set.push_back(p);
    }
  return made;
}

Case crossing_frame(FeatureKind kind, int control_points, const Vec3& p, const Vec3& q, const Vec3& z) {
  Case made;
  made.kind = kind;
  made.control_points = control_points;
  const auto add = [&](std::size_t set, double x, double y, double height) {
    Curve point;
    for (std::size_t k = 0; k < 3; ++k) {
      const int at = static_cast<int>(k);
      point[k] = Vec3(x * p[at], y * q[at], height * z[at]);
    }
    made.sets[set].push_back(point);
  };
  if (kind == FeatureKind::vf) {
    add(0, 0, 0, 0);
    add(1, -1, -1, 1);
    add(1, 1, -1, 1);
    add(1, 0, 1, 1);
  } else {
    add(0, -1, 0, 0);
    add(0, 1, 0, 0);
    add(1, 0, -1, 1);
    add(1, 0, 1, 1);
  }
  return made;
}

}  // namespace volccd::cases
