#include <volccd/narrowphase/cubic/cubic.hpp>

#include <cassert>

#include <volccd/narrowphase/contact_frame.hpp>
#include <volccd/narrowphase/cubic/detail/coplanar_events.hpp>
#include <volccd/narrowphase/cubic/detail/polynomial_roots.hpp>
#include <volccd/narrowphase/detail/coplanarity_block.hpp>

namespace volccd {
namespace {

using namespace detail;

enum class Verdict {
  apart,
  touch,
  unclear  ///< some root is not proven with these coefficients
};

/// Contacts whose time is not proven to have this accuracy are recomputed with refined coefficients.
constexpr double kTimeAccuracy = 0x1p-42;

/// An interval of the step. The parameter of a cubic in it is 0 at lo and 1 at hi.
struct Window {
  double lo = 0, hi = 1;
  double at(double s) const { return s < 1 ? lo + s * (hi - lo) : hi; }
};

/// A test that the first pass left open.
class ElementaryTest {
 public:
  /// Keeps a reference to `points`.
  ElementaryTest(FeatureKind kind, const MovingPoints& points, double tolerance, double t_max)
      : kind_(kind), points_(points), tolerance_(tolerance), t_max_(t_max) {
    measure();
  }

  /// Allows coefficients to be refined again over a shorter interval of the step. Keeps a reference to `x`.
  void refine_from(const TestPoints& x, double scale) { x_ = &x, scale_ = scale; }

  /// To be called after the points were rescaled.
  void measure() {
    distance_ = tolerance_ * points_.size;
    // An error of this size in a root moves the features by less than half the distance.
    slack_ = points_.travel > 0 ? std::min(1.0, distance_ / (8 * points_.travel)) : 1.0;
  }

  /// Searches for the first root in [0, t_max] at which the features touch. `refined`: the coefficients are almost
  /// exact; then intervals in which the sign is not proven are treated as coplanar, and no result is unclear.
  Verdict solve(const CoplanarityCubic& cubic, bool refined, const Window& window = {}) {
    const MonotonePieces pieces = monotone_pieces(cubic);
    for (std::size_t k = 0; k < static_cast<std::size_t>(pieces.count); ++k) {
      const double a = pieces.cut[k], b = pieces.cut[k + 1];
      if (window.at(a) > t_max_) break;
      const int before = cubic.sign(a), after = cubic.sign(b);
      if (before * after > 0) continue;
      const Verdict verdict = before * after < 0 ? crossing(cubic, a, b, before, refined, window)
                                                 : unproven(cubic, a, b, before, after, refined, window);
      if (verdict != Verdict::apart) return verdict;
    }
    return Verdict::apart;
  }

  bool degenerate() const { return degenerate_; }
  double time() const { return touch_.t; }
  int side() const { return side_; }
  const std::array<double, 4>& weights() const { return touch_.closest.weights; }
  double distance() const { return distance_; }

 private:
  /// Processes a piece whose ends have opposite signs and which therefore has one root.
  Verdict crossing(const CoplanarityCubic& cubic, double a, double b, int before, bool refined, const Window& window) {
    if (window.lo == 0 && window.hi == 1 && b > t_max_ && cubic.sign(t_max_) == before) return Verdict::apart;
    const double root = bracketed_root(cubic, a, b);
    const auto within = [&](double slack) {
      return cubic.sign(std::max(a, root - slack)) == before && cubic.sign(std::min(b, root + slack)) == -before;
    };
    if (within(slack_ / (window.hi - window.lo))) {
      const Verdict verdict = touches_at(window.at(root), before);
      return verdict == Verdict::touch && !refined && !within(kTimeAccuracy) ? Verdict::unclear : verdict;
    }
    return refined ? open_stretch(zero_stretch(cubic, a, b), before, {root, root}, window) : Verdict::unclear;
  }

  /// Processes a piece with an end that may be a root.
  Verdict unproven(const CoplanarityCubic& cubic, double a, double b, int before, int after, bool refined,
                   const Window& window) {
    if (!refined) return Verdict::unclear;
    const double slack = slack_ / (window.hi - window.lo);
    // There is no motion before the start; the motion is extrapolated backwards.
    const bool at_start = a == 0 && window.lo == 0;
    if (before == 0 && after != 0 && cubic.sign(std::min(b, a + slack)) == after)
      return touches_at(window.at(a), at_start ? -after : after);
    if (after == 0 && before != 0 && cubic.sign(std::max(a, b - slack)) == before)
      return touches_at(window.at(b), before);
    const int side = before != 0 ? before : at_start ? -after : after;
    return open_stretch(zero_stretch(cubic, a, b), side, {before == 0 ? a : b, after == 0 ? b : a}, window);
  }

  /// Processes an interval of the window in which the sign is not proven: a short one is examined again with its own
  /// coefficients; otherwise it is treated as coplanar.
  Verdict open_stretch(const std::array<double, 2>& stretch, int side, std::array<double, 2> roots,
                       const Window& window) {
    constexpr double kShort = 0.125;
    degenerate_ = true;
    const Window interval{window.at(stretch[0]), window.at(stretch[1])};
    if (x_ && interval.hi > interval.lo && stretch[1] - stretch[0] < kShort)
      return solve(refined_coplanarity(*x_, scale_, interval.lo, interval.hi), true, interval);
    for (double& root : roots) root = window.at(root);
    return coplanar({interval.lo, interval.hi}, side, roots);
  }

  Verdict touches_at(double t, int side) {
    if (t > t_max_) return Verdict::apart;
    const Differences d = points_.at(t);
    if (clearly_apart(kind_, d, distance_, points_.size)) return Verdict::apart;
    touch_ = {t, closest_points(kind_, d)};
    side_ = side;
    return touch_.closest.squared_distance <= distance_ * distance_ ? Verdict::touch : Verdict::apart;
  }

  /// Processes an interval in which the sign is not proven. `roots`, ascending: the times in it at which the features
  /// seem to change sides. If the features overlap in the projection along their normal at such a time, they touch
  /// then, and no contact begins within their plane.
  Verdict coplanar(const std::array<double, 2>& stretch, int side, const std::array<double, 2>& roots) {
    const std::optional<Touch> event = first_coplanar_touch(kind_, points_, stretch[0], stretch[1], distance_, slack_);
    for (const double root : roots) {
      if (event && event->t <= root) break;
      if (touches_at(root, side) == Verdict::touch) return Verdict::touch;
    }
    if (!event || event->t > t_max_) return Verdict::apart;
    touch_ = *event;
    side_ = side;
    return Verdict::touch;
  }

  FeatureKind kind_;
  const MovingPoints& points_;
  const TestPoints* x_ = nullptr;
  double scale_ = 1;
  double tolerance_, t_max_, distance_ = 0, slack_ = 0;
  bool degenerate_ = false;
  int side_ = 0;
  Touch touch_{};
};

Contact make_contact(FeatureKind kind, const std::array<Index, 4>& vertices, const TestPoints& x,
                     const MovingPoints& points, const ElementaryTest& test) {
  Contact contact;
  contact.kind = kind;
  contact.vertices = vertices;
  contact.toi = test.time();
  contact.at_start = contact.toi == 0;
  contact.normal = contact_normal(kind, points, test.time(), test.side());
  contact.weights = test.weights();
  contact.point = contact_point(kind, x, test.time(), test.weights());
  return contact;
}

/// Second pass: processes one test that may touch.
void test_open(const Step& step, FeatureKind kind, const std::array<Index, 4>& vertices, const CoplanarityCubic& cubic,
               double tolerance, std::vector<Contact>& contacts, NarrowCounters& counters) {
  const TestPoints x = test_points(step.motion, vertices);
  MovingPoints points = moving_points(x, 1);
  ElementaryTest test(kind, points, tolerance, step.t_max);
  Verdict verdict = test.solve(cubic, false);
  if (verdict == Verdict::unclear) {
    const double scale = range_scale(x);
    if (scale != 1) {
      points = moving_points(x, scale);
      test.measure();
    }
    test.refine_from(x, scale);
    verdict = centroid_axis_separates(kind, points, test.distance()) ? Verdict::apart
                                                                     : test.solve(refined_coplanarity(x, scale), true);
    counters.degenerate += test.degenerate() ? 1 : 0;
  }
  if (verdict == Verdict::touch) contacts.push_back(make_contact(kind, vertices, x, points, test));
}

}  // namespace

const Options<Cubic::Config>& Cubic::options() {
  static const Options<Config> table = [] {
    Options<Config> options;
    options.add("tolerance", &Config::tolerance, 1e-13, 1e-3,
                "distance that counts as touching, relative to the size of a test");
    options.add("axis_test", &Config::axis_test, "drop tests that the x, y or z axis separates before the cubic");
    options.add("coplanarity", &Config::coplanarity,
                "drop tests whose Bernstein coefficients have one sign before the search for roots");
    return options;
  }();
  return table;
}

void Cubic::run(const Step& step, StageState&, unsigned, const TestBlock& block, std::vector<Contact>& contacts,
                NarrowCounters& counters) const {
  assert(step.motion.control_points() == 2 && step.separation == 0);
  CoplanarityBlock cubics;
  cubics.compute(block, config_.axis_test, config_.coplanarity);
  for (std::size_t i = 0; i < block.size(); ++i)
    if (cubics.open(i))
      test_open(step, block.kind(), block.vertices(i), cubics.cubic(i), config_.tolerance, contacts, counters);
}

StageDescriptor<NarrowPhase> describe_cubic() {
  return describe_stage<NarrowPhase, Cubic>(
      "cubic", "coplanarity cubic and inside test in doubles (Provot; Bridson et al.)", Guarantee::approximate);
}

}  // namespace volccd
