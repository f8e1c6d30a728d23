#include <volccd/oracle/overlap_oracle.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <volccd/core/error.hpp>
#include <volccd/oracle/detail/convex_pieces.hpp>
#include <volccd/oracle/detail/fcl_pieces.hpp>
#include <volccd/oracle/detail/separation.hpp>

namespace volccd {

namespace {

using detail::append_pieces;
using detail::ConvexPiece;
using detail::Cover;

/// All elements at one time in CSR form: the points whose hull contains the element, and its convex pieces.
struct Bodies {
  std::vector<std::size_t> point_offsets, piece_offsets;  ///< [slots + 1]
  std::vector<Vec3> points;
  std::vector<ConvexPiece> pieces;
  std::uint64_t inexact = 0;  ///< elements whose pieces differ from the body

  std::span<const Vec3> hull(Index o) const { return run(points, point_offsets, o); }
  std::span<const ConvexPiece> of(Index o) const { return run(pieces, piece_offsets, o); }

 private:
  template <class T>
  static std::span<const T> run(const std::vector<T>& values, const std::vector<std::size_t>& offsets, Index o) {
    return {values.data() + offsets[o], offsets[std::size_t{o} + 1] - offsets[o]};
  }
};

Bodies bodies_at(const Step& step, double t, Cover cover) {
  const Mesh& mesh = step.mesh();
  std::vector<Vec3> positions(mesh.vertex_count());
  for (Index v = 0; v < mesh.vertex_count(); ++v) positions[v] = step.motion.position(v, t);
  Bodies bodies;
  bodies.point_offsets.push_back(0);
  bodies.piece_offsets.push_back(0);
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    for (const Index v : mesh.vertices(o)) bodies.points.push_back(positions[v]);
    if (mesh.is_live(o) && !append_pieces(mesh, positions, o, cover, bodies.pieces)) ++bodies.inexact;
    bodies.point_offsets.push_back(bodies.points.size());
    bodies.piece_offsets.push_back(bodies.pieces.size());
  }
  return bodies;
}

struct Box {
  Vec3 low = Vec3::Constant(INFINITY), high = Vec3::Constant(-INFINITY);

  double diagonal() const { return (high - low).norm(); }
};

Box box_of(std::span<const Vec3> points) {
  Box box;
  for (const Vec3& p : points) {
    box.low = box.low.cwiseMin(p);
    box.high = box.high.cwiseMax(p);
  }
  return box;
}

/// Widest gap along a coordinate axis; negative if the boxes overlap.
double gap(const Box& a, const Box& b) { return (a.low - b.high).cwiseMax(b.low - a.high).maxCoeff(); }

bool apart(const Box& a, const Box& b) { return gap(a, b) > 0; }

/// The largest depth over all pairs of pieces that FCL finds overlapping and that no axis separates; negative if there
/// are none.
double overlap_depth(const Bodies& bodies, ElementPair pair, detail::FclOverlap& overlap) {
  const std::span<const Vec3> hull_a = bodies.hull(pair.a), hull_b = bodies.hull(pair.b);
  const Box box_a = box_of(hull_a), box_b = box_of(hull_b);
  double depth = -1;
  if (bodies.of(pair.a).size() * bodies.of(pair.b).size() > 1 && !overlap(hull_a, hull_b)) return depth;
  for (const ConvexPiece& p : bodies.of(pair.a)) {
    const Box box_p = box_of(p.span());
    if (apart(box_p, box_b)) continue;
    for (const ConvexPiece& q : bodies.of(pair.b)) {
      const Box box_q = box_of(q.span());
      if (!apart(box_q, box_a) && !apart(box_p, box_q) && overlap(p.span(), q.span()))
        depth = std::max(depth, -detail::signed_gap(p, q));
    }
  }
  return depth;
}

/// Whether the two bodies are certainly disjoint: for every pair of their pieces there is an axis with a gap larger
/// than the rounding error.
bool certainly_disjoint(const Bodies& bodies, ElementPair pair) {
  const Box box_a = box_of(bodies.hull(pair.a)), box_b = box_of(bodies.hull(pair.b));
  const Box both{box_a.low.cwiseMin(box_b.low), box_a.high.cwiseMax(box_b.high)};
  const double rounding = 1e-15 * std::max(both.low.cwiseAbs().maxCoeff(), both.high.cwiseAbs().maxCoeff());
  const double min = 1e-9 * both.diagonal() + 16 * rounding;
  if (gap(box_a, box_b) > min) return true;
  for (const ConvexPiece& p : bodies.of(pair.a))
    for (const ConvexPiece& q : bodies.of(pair.b))
      if (!(detail::signed_gap(p, q) > min)) return false;
  return true;
}

struct Sample {
  std::vector<Overlap> overlaps;
  std::uint64_t candidates = 0, surface_only = 0;
};

Sample sample(const Step& step, double t, Executor& executor) {
  const Mesh& mesh = step.mesh();
  const Bodies bodies = bodies_at(step, t, Cover::within);
  std::vector<detail::ElementBox> boxes;
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.is_live(o)) {
      const Box box = box_of(bodies.hull(o));
      boxes.push_back({o, box.low, box.high});
    }
  std::vector<ElementPair> pairs = detail::box_overlaps(boxes);
  std::erase_if(pairs, [&](ElementPair p) { return detail::share_vertex(mesh, p.a, p.b); });
  std::sort(pairs.begin(), pairs.end());

  std::vector<double> depths(pairs.size());
  executor.parallel_for(pairs.size(), 256, [&](std::size_t begin, std::size_t end, unsigned) {
    detail::FclOverlap overlap;
    for (std::size_t i = begin; i < end; ++i) depths[i] = overlap_depth(bodies, pairs[i], overlap);
  });
  Sample result;
  result.candidates = pairs.size();
  result.surface_only = bodies.inexact;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (depths[i] >= 0) result.overlaps.push_back({pairs[i], depths[i]});
  return result;
}

/// Contacts in canonical order, which can be searched by the features of two elements.
class ContactIndex {
 public:
  explicit ContactIndex(std::span<const Contact> contacts) {
    for (const Contact& c : contacts) entries_.push_back({c.kind, c.vertices, c.toi});
    std::sort(entries_.begin(), entries_.end(), less);
  }

  /// Earliest contact between a feature of a and a feature of b; infinity if there is none.
  double first_between(const Mesh& mesh, Index a, Index b) const {
    double first = INFINITY;
    std::vector<std::array<Index, 3>> triangles_a, triangles_b;
    detail::boundary_triangles(mesh, a, triangles_a);
    detail::boundary_triangles(mesh, b, triangles_b);
    first = std::min(first, first_vf(mesh.vertices(a), triangles_b));
    first = std::min(first, first_vf(mesh.vertices(b), triangles_a));
    // The smaller edge of a contact is first, whichever element it belongs to.
    first = std::min(first, first_ee(triangles_a, triangles_b));
    return std::min(first, first_ee(triangles_b, triangles_a));
  }

 private:
  struct Entry {
    FeatureKind kind;
    std::array<Index, 4> vertices;
    double toi;
  };
  using Triangles = std::vector<std::array<Index, 3>>;

  static bool less(const Entry& x, const Entry& y) {
    return x.kind != y.kind ? x.kind < y.kind : x.vertices < y.vertices;
  }

  /// First entry of a kind whose vertices do not come before {v0, v1, ...}.
  std::vector<Entry>::const_iterator begin_of(FeatureKind kind, Index v0, Index v1) const {
    return std::lower_bound(entries_.begin(), entries_.end(), Entry{kind, {v0, v1, 0, 0}, 0}, less);
  }

  double first_vf(std::span<const Index> vertices, const Triangles& triangles) const {
    double first = INFINITY;
    for (const Index v : vertices)
      for (auto e = begin_of(FeatureKind::vf, v, 0);
           e != entries_.end() && e->kind == FeatureKind::vf && e->vertices[0] == v; ++e)
        if (e->toi < first && has_triangle(triangles, {e->vertices[1], e->vertices[2], e->vertices[3]})) first = e->toi;
    return first;
  }

  double first_ee(const Triangles& of_first, const Triangles& of_second) const {
    double first = INFINITY;
    for (const auto& f : of_first)
      for (std::size_t i = 0; i < 3; ++i) {
        const auto [v0, v1] = std::minmax(f[i], f[(i + 1) % 3]);
        for (auto e = begin_of(FeatureKind::ee, v0, v1);
             e != entries_.end() && e->kind == FeatureKind::ee && e->vertices[0] == v0 && e->vertices[1] == v1; ++e)
          if (e->toi < first && has_edge(of_second, e->vertices[2], e->vertices[3])) first = e->toi;
      }
    return first;
  }

  static bool has_triangle(const Triangles& triangles, const std::array<Index, 3>& ascending) {
    return std::any_of(triangles.begin(), triangles.end(), [&](std::array<Index, 3> f) {
      std::sort(f.begin(), f.end());
      return f == ascending;
    });
  }

  static bool has_edge(const Triangles& triangles, Index v0, Index v1) {
    return std::any_of(triangles.begin(), triangles.end(), [&](const std::array<Index, 3>& f) {
      return std::find(f.begin(), f.end(), v0) != f.end() && std::find(f.begin(), f.end(), v1) != f.end();
    });
  }

  std::vector<Entry> entries_;
};

void refuse_what_owes_nothing(const Step& step, std::span<const double> times) {
  if (step.features().edge_set() != EdgeSet::triangulated)
    throw ConfigError(
        "the overlap oracle needs the edge set `triangulated`: without face diagonals contacts are incomplete");
  for (const double t : times)
    if (!(t >= 0 && t <= step.t_max))
      throw ConfigError("the overlap oracle was asked about time " + std::to_string(t) + ", which is not in [0, " +
                        std::to_string(step.t_max) + "]");
}

/// Whether some axis separates the hulls at t = 0 by more than the separation plus 1e-9 of the pair's size. FCL is not
/// used, because it may miss a shallow overlap.
bool hulls_clearly_apart(const Step& step, ElementPair pair) {
  std::vector<Vec3> a, b;
  for (const Index v : step.mesh().vertices(pair.a)) a.push_back(step.motion.point(v, 0));
  for (const Index v : step.mesh().vertices(pair.b)) b.push_back(step.motion.point(v, 0));
  const Box box_a = box_of(a), box_b = box_of(b);
  const Box both{box_a.low.cwiseMin(box_b.low), box_a.high.cwiseMax(box_b.high)};
  const double rounding = 1e-15 * std::max(both.low.cwiseAbs().maxCoeff(), both.high.cwiseAbs().maxCoeff());
  return detail::signed_gap(a, b) > step.separation * (1 + 1e-9) + 1e-9 * both.diagonal() + 16 * rounding;
}

enum class Verdict : char { confirmed, initial, shallow, filtered, violation };

}  // namespace

std::vector<Overlap> overlapping_elements(const Step& step, double t, Executor& executor) {
  if (!(t >= 0 && t <= 1)) throw ConfigError("a time of a step is in [0, 1], not " + std::to_string(t));
  return sample(step, t, executor).overlaps;
}

InitialOverlapReport check_initial_overlaps(const Step& step, std::span<const ElementPair> listed, Executor& executor) {
  const Mesh& mesh = step.mesh();
  const auto allowed = [&](ElementPair p) { return step.filter.allows(mesh.object(p.a), mesh.object(p.b)); };
  InitialOverlapReport report;
  for (const Overlap& overlap : sample(step, 0, executor).overlaps) {
    if (!allowed(overlap.pair)) continue;
    ++report.hits;
    if (!std::binary_search(listed.begin(), listed.end(), overlap.pair)) report.missing.push_back(overlap);
  }
  std::vector<char> wrong(listed.size());
  executor.parallel_for(listed.size(), 64, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto [a, b] = listed[i];
      const bool valid = a < b && b < mesh.element_slots() && mesh.is_live(a) && mesh.is_live(b) &&
                         allowed(listed[i]) && !detail::share_vertex(mesh, a, b) &&
                         (i == 0 || listed[i - 1] < listed[i]);
      wrong[i] = !valid || hulls_clearly_apart(step, listed[i]);
    }
  });
  for (std::size_t i = 0; i < wrong.size(); ++i)
    if (wrong[i] != 0) report.extra.push_back(listed[i]);
  return report;
}

OverlapReport check_against_fcl(const Step& step, std::span<const Contact> contacts, std::span<const double> times,
                                Executor& executor, const OverlapCheck& check) {
  refuse_what_owes_nothing(step, times);
  const Mesh& mesh = step.mesh();
  const ContactIndex index(contacts);
  const Bodies start = bodies_at(step, 0, Cover::around);
  OverlapReport report;
  std::vector<Verdict> verdicts;
  std::vector<double> first;
  for (const double t : times) {
    const Sample found = sample(step, t, executor);
    verdicts.assign(found.overlaps.size(), Verdict::violation);
    first.assign(found.overlaps.size(), INFINITY);
    executor.parallel_for(found.overlaps.size(), 16, [&](std::size_t begin, std::size_t end, unsigned) {
      for (std::size_t i = begin; i < end; ++i) {
        const auto [a, b] = found.overlaps[i].pair;
        const double size = std::min(box_of(start.hull(a)).diagonal(), box_of(start.hull(b)).diagonal());
        if (!step.filter.allows(mesh.object(a), mesh.object(b))) {
          verdicts[i] = Verdict::filtered;
        } else if (!certainly_disjoint(start, {a, b})) {
          verdicts[i] = Verdict::initial;
        } else {
          first[i] = index.first_between(mesh, a, b);
          if (first[i] <= t + check.time_tolerance)
            verdicts[i] = Verdict::confirmed;
          else if (found.overlaps[i].depth < check.min_depth * size)
            verdicts[i] = Verdict::shallow;
        }
      }
    });
    ++report.times;
    report.candidates += found.candidates;
    report.surface_only += found.surface_only;
    report.hits += found.overlaps.size();
    for (std::size_t i = 0; i < verdicts.size(); ++i) switch (verdicts[i]) {
        case Verdict::confirmed: ++report.confirmed; break;
        case Verdict::initial: ++report.initial; break;
        case Verdict::shallow: ++report.shallow; break;
        case Verdict::filtered: ++report.filtered; break;
        case Verdict::violation:
          report.violations.push_back({found.overlaps[i].pair, t, found.overlaps[i].depth, first[i]});
      }
  }
  return report;
}

}  // namespace volccd
