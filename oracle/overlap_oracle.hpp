// Checks the contacts of pipelines against the elements that FCL finds overlapping at sampled times.
//
// An element at time t is its triangulated surface together with every point that the surface winds around. A quad face
// is split by the diagonal through its smallest vertex, a polytope's face into a fan around its smallest vertex, as in
// the library. If two such bodies without a common vertex are disjoint at t = 0 and not at t, their surfaces have met
// in between, and so a vertex or edge of one has met a triangle or edge of the other: there must be a contact with one
// feature in each element and a time <= t. This holds for non-planar faces, and for inverted and degenerate elements.
// FCL is given convex pieces: a tetrahedron, a triangle, and for other elements the tetrahedra between their centroid
// and each boundary triangle. If these do not all have the same orientation (badly distorted elements), they may cover
// more than the body. Then FCL is given only the surface at t, and all pieces at t = 0, so that no pair is skipped and
// none is reported wrongly. The oracle shares no code with the stages and the feature tables.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/query/contact.hpp>
#include <volccd/query/step.hpp>

namespace volccd {

/// Two live elements without a common vertex, a < b, that FCL finds overlapping.
struct Overlap {
  ElementPair pair;
  /// Penetration depth: the largest depth over their convex pieces, in the unit of the positions. It is a lower
  /// estimate for elements of several pieces.
  double depth;
};

/// A pair that should have a contact and has none.
struct OverlapViolation {
  ElementPair pair;      ///< slots
  double time;           ///< FCL finds them overlapping at this time
  double depth;          ///< as in Overlap
  double first_contact;  ///< earliest contact between the two elements, later than `time`; infinity if there is none at
                         ///< all
};

struct OverlapReport {
  std::uint64_t times = 0;       ///< sampled
  std::uint64_t candidates = 0;  ///< pairs of non-adjacent elements with overlapping boxes, summed over the times
  std::uint64_t hits = 0;        ///< of those, pairs that FCL finds overlapping: the next four plus the violations
  std::uint64_t confirmed = 0;   ///< disjoint at t = 0, and with a contact in time
  std::uint64_t initial = 0;     ///< not certainly disjoint at t = 0: no contact is required
  std::uint64_t shallow = 0;     ///< less deep than OverlapCheck::min_depth
  std::uint64_t filtered = 0;    ///< step.filter excludes the two objects
  /// Elements of which only the surface could be tested, summed over the times.
  std::uint64_t surface_only = 0;
  std::vector<OverlapViolation> violations;  ///< by time as given, then by pair

  bool clean() const { return violations.empty(); }
};

struct OverlapCheck {
  /// A contact is in time if its toi is at most this later than the sampled time.
  double time_tolerance = 1e-6;
  /// Hits less deep than this, in units of the smaller element's box diagonal, are counted but are no violations. FCL's
  /// hits are reliable, but positions at times inside the step are rounded, and an approximate narrow phase is not more
  /// accurate.
  double min_depth = 1e-6;
};

/// Result of checking a list of initial overlaps. Elements are represented by the convex hulls of their vertices, which
/// contain their bodies.
struct InitialOverlapReport {
  std::uint64_t hits = 0;        ///< pairs that FCL finds overlapping at t = 0 and step.filter allows
  std::vector<Overlap> missing;  ///< hits that are not listed
  /// Listed pairs that are invalid (they share a vertex, are not live, not in the order a < b, or not allowed), and
  /// those that some axis separates by more than step.separation plus 1e-9 of the pair's size.
  std::vector<ElementPair> extra;

  bool clean() const { return missing.empty() && extra.empty(); }
};

/// Compares a list of initial overlaps, ascending, with FCL and with separating axes in plain doubles.
InitialOverlapReport check_initial_overlaps(const Step& step, std::span<const ElementPair> listed, Executor& executor);

/// All overlaps at time t in [0,1], in ascending order of pairs. Each pair returned overlaps; overlaps less deep than
/// about 1e-6 of the elements' size (1e-4 for slivers) may be missing. O(n log n + box overlaps).
std::vector<Overlap> overlapping_elements(const Step& step, double t, Executor& executor);

/// Compares the contacts of a step (in any order) with the overlaps at the given times. Throws ConfigError if a time is
/// not in [0, step.t_max], or if the edge set lacks the face diagonals, without which contacts are not complete.
OverlapReport check_against_fcl(const Step& step, std::span<const Contact> contacts, std::span<const double> times,
                                Executor& executor, const OverlapCheck& check = {});

}  // namespace volccd
