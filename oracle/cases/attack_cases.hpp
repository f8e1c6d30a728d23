// Families of VF and EE tests that are hard on elementary tests: they touch by construction, or an exact judge says
// whether they do.
#pragma once

#include <ostream>
#include <span>

#include <volccd/oracle/cases/near_degenerate.hpp>

#include <volccd/query/pairs.hpp>

namespace volccd::cases {

struct Attack {
  const char* name;
  /// How many make a short test: some take an exact judge long.
  int cases;
  /// The features. Case::touch is set where they are known to come within the separation by then.
  Case (*make)(Choices& choices, FeatureKind kind, int control_points);
};

inline void PrintTo(const Attack& attack, std::ostream* out) { *out << attack.name; }

/// Without a separation.
std::span<const Attack> touching_attacks();
/// With one.
std::span<const Attack> separation_attacks();

/// A kind and degree that are chosen as well.
Case attack_test(Choices& choices, const Attack& attack);
/// One of a list.
Case any_attack_test(Choices& choices, std::span<const Attack> attacks);
/// With points around the features, up to `count` in each set, made of their coordinates.
Case any_attack_elements(Choices& choices, std::span<const Attack> attacks, FeatureKind kind, int control_points,
                         std::size_t count);

/// Features that overlap as seen along z as long as p and q are positive, and touch as z passes through 0: control
/// values of p, q and z. VF: a vertex at the origin, a triangle (-p,-q,z), (p,-q,z), (0,q,z). EE: edges (-p,0,0),
/// (p,0,0) and (0,-q,z), (0,q,z).
Case crossing_frame(FeatureKind kind, int control_points, const Vec3& p, const Vec3& q, const Vec3& z);

}  // namespace volccd::cases
