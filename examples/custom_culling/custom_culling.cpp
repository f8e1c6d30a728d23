// A culling stage of one's own, measured like all others: it drops element pairs whose swept bounding spheres are
// apart. The spheres are the stage's state. docs/adding_a_stage.md explains this file.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include <volccd/program/program.hpp>

using namespace volccd;

namespace {

class SphereCulling final : public ElementCulling {
 public:
  struct Config {
    double padding = 1e-9;  ///< added to each radius, relative to the largest coordinate; far above all rounding
  };
  static const Options<Config>& options() {
    static const Options<Config> table =
        Options<Config>().add("padding", &Config::padding, 1e-9, 1.0, "widening, relative to the largest coordinate");
    return table;
  }
  explicit SphereCulling(const Config& config) : config_(config) {}

  std::unique_ptr<StageState> make_state() const override { return std::make_unique<State>(); }

  /// Called once for each step. The state is that of the last step, so that its memory is used again.
  void prepare(const Step& step, StageState& state, Executor& executor) const override {
    std::vector<Sphere>& spheres = static_cast<State&>(state).spheres;
    spheres.resize(step.mesh().element_slots());
    executor.parallel_for(spheres.size(), 1024, [&](std::size_t begin, std::size_t end, unsigned) {
      for (std::size_t o = begin; o < end; ++o) spheres[o] = sphere(step, static_cast<Index>(o));
    });
  }

  /// Called for each batch of pairs, by several threads at once; the state is only read.
  void run(const Step& step, StageState& state, unsigned, PairBatch& batch) const override {
    const std::vector<Sphere>& spheres = static_cast<const State&>(state).spheres;
    batch.cull([&](ElementPair pair, auto& /* which features cannot touch */) {
      const Sphere &a = spheres[pair.a], &b = spheres[pair.b];
      const Vec3 d = a.centre - b.centre;
      // With this comparison, a NaN or an infinity (overflow) keeps the pair, because a conservative stage may drop
      // only pairs that it can decide.
      const bool apart = std::hypot(d.x(), d.y(), d.z()) > a.radius + b.radius + step.separation;
      return apart ? PairVerdict::disjoint : PairVerdict::keep;
    });
  }

 private:
  struct Sphere {
    Vec3 centre;
    double radius;
  };
  struct State final : StageState {
    std::vector<Sphere> spheres;  ///< by element
    std::size_t bytes() const override { return spheres.capacity() * sizeof(Sphere); }
  };

  /// A sphere around all control points of an element's vertices contains its whole motion (convex-hull property).
  Sphere sphere(const Step& step, Index element) const {
    const auto vertices = step.mesh().vertices(element);
    const int points = step.motion.control_points();
    Vec3 low = Vec3::Constant(HUGE_VAL), high = -low;
    for (const Index v : vertices)
      for (int c = 0; c < points; ++c) {
        low = low.cwiseMin(step.motion.point(v, c));
        high = high.cwiseMax(step.motion.point(v, c));
      }
    Sphere result{(low + high) / 2, 0};
    for (const Index v : vertices)
      for (int c = 0; c < points; ++c) {
        const Vec3 d = step.motion.point(v, c) - result.centre;
        result.radius = std::max(result.radius, std::hypot(d.x(), d.y(), d.z()));
      }
    const double largest = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
    result.radius += config_.padding * largest + std::numeric_limits<double>::min();
    return result;
  }

  Config config_;
};

}  // namespace

int main(int argc, char** argv) {
  Registry registry = Registry::standard();
  registry.add(describe_stage<ElementCulling, SphereCulling>(
      "spheres", "drops pairs whose swept bounding spheres are apart", Guarantee::conservative));
  auto spec = registry.pipeline("VolCCD+");
  spec.name = "Spheres";
  spec.description = "VolCCD+ with bounding spheres in the place of CSAT";
  spec.element_culling = {{"spheres", {}}};
  registry.add_pipeline(spec);
  spec.name = "Spheres+CSAT";
  spec.description = "VolCCD+ with bounding spheres before CSAT";
  spec.element_culling = {{"spheres", {}}, {"csat", {{"axis", "optimal"}, {"mode", "pair"}}}};
  registry.add_pipeline(spec);
  return program(argc, argv, registry);
}
