#include <volccd/oracle/cases/near_degenerate.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <volccd/oracle/cases/contact_builder.hpp>

namespace volccd::cases {
Case near_degenerate(Choices& choices, FeatureKind kind, int control_points, std::size_t first, std::size_t second,
                     Separation separation) {
  ContactBuilder builder(choices, kind, control_points);
  builder.features();
  builder.fill(0, first);
  builder.fill(1, second);
  if (separation == Separation::some) builder.move_apart();
  builder.transform();
  builder.scale();
  builder.round_and_nudge();
  builder.reorder();
  return builder.build();
}

Case near_degenerate_test(Choices& choices, Separation separation) {
  const FeatureKind kind = choices.below(2) ? FeatureKind::ee : FeatureKind::vf;
  const int control_points = 2 + choices.below(2);
  return kind == FeatureKind::vf ? near_degenerate(choices, kind, control_points, 1, 3, separation)
                                 : near_degenerate(choices, kind, control_points, 2, 2, separation);
}

Coordinates::Coordinates(const Case& c) : kind_(c.kind), control_points_(c.control_points) {
  for (std::size_t i = 0; i < 4; ++i) {
    const Curve& p = i < c.own(0) ? c.sets[0][i] : c.sets[1][i - c.own(0)];
    for (std::size_t k = 0; k < 9; ++k) points_[i][k] = p[k / 3][static_cast<int>(k % 3)];
  }
}

TestMotion Coordinates::motion() const {
  return {kind_, control_points_, {points_[0].data(), points_[1].data(), points_[2].data(), points_[3].data()}};
}

double Coordinates::size() const {
  double size = 0;
  for (std::size_t i = 1; i < 4; ++i)
    for (std::size_t j = 0; j < i; ++j)
      for (std::size_t k = 0; k < 3 * static_cast<std::size_t>(control_points_); ++k)
        size = std::max(size, std::abs(points_[i][k] - points_[j][k]));
  return size;
}

bool touches(const Case& c, double t_max) {
  if (c.touch >= 0 && c.touch <= t_max) return true;
  return exact_first_touch(Coordinates(c).motion(), t_max, c.separation).touches;
}

std::string to_text(const Case& c) {
  char text[128];
  std::string all = c.kind == FeatureKind::vf ? "VF" : "EE";
  std::snprintf(text, sizeof text, ", %d control points, separation %a, touch by %a\n", c.control_points, c.separation,
                c.touch);
  all += text;
  for (const auto& set : c.sets) {
    for (const Curve& p : set) {
      for (std::size_t k = 0; k < static_cast<std::size_t>(c.control_points); ++k) {
        std::snprintf(text, sizeof text, "  {%a, %a, %a},", p[k].x(), p[k].y(), p[k].z());
        all += text;
      }
      all += "\n";
    }
    all += "\n";
  }
  return all;
}

}  // namespace volccd::cases
