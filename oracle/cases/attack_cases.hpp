// Families of VF and EE cases that are difficult for elementary tests. The features touch by construction, or an exact
// test decides whether they do.
#pragma once

#include <ostream>
#include <span>

#include <volccd/oracle/cases/near_degenerate.hpp>

#include <volccd/query/pairs.hpp>

namespace volccd::cases {

struct Attack {
  const char* name;
  /// Number of cases in a short test; some families are slow to decide exactly.
  int cases;
  /// Makes the features. Case::touch is set if they are known to come within the separation by that time.
  Case (*make)(Choices& choices, FeatureKind kind, int control_points);
};

inline void PrintTo(const Attack& attack, std::ostream* out) { *out << attack.name; }

/// Families without a separation.
std::span<const Attack> touching_attacks();
/// Families with a separation.
std::span<const Attack> separation_attacks();

/// A case of this family, whose kind and number of control points are chosen as well.
Case attack_test(Choices& choices, const Attack& attack);
/// A case of one of these families.
Case any_attack_test(Choices& choices, std::span<const Attack> attacks);
/// The same, with further points around the features, up to `count` in each set, which are made from the features'
/// coordinates.
Case any_attack_elements(Choices& choices, std::span<const Attack> attacks, FeatureKind kind, int control_points,
                         std::size_t count);

/// Features whose projections along z overlap while p and q are positive, and which touch when z passes through 0. The
/// arguments are control values of p, q and z. VF: a vertex at the origin, a triangle (-p,-q,z), (p,-q,z), (0,q,z). EE:
/// edges (-p,0,0), (p,0,0) and (0,-q,z), (0,q,z).
Case crossing_frame(FeatureKind kind, int control_points, const Vec3& p, const Vec3& q, const Vec3& z);

}  // namespace volccd::cases
