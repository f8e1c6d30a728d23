// A culling idea of one's own, measured against all the others: element pairs whose swept bounding spheres are apart are
// dropped. The stage is defined and registered here, outside the library; all commands of the program, `verify` included, know
// it all the same:
//
//     custom_culling stages
//     custom_culling detect FILE --pipeline Spheres --set spheres.padding=0.1
//     custom_culling detect FILE --pipeline VolCCD+ --set element-culling=spheres,csat
//     custom_culling verify FILE
#include <Eigen/Geometry>

#include <volccd/program/program.hpp>

namespace {

using namespace volccd;

class SphereCulling final : public ElementCulling {
 public:
  struct Config {
    double padding = 1e-9;  ///< added to each radius, relative to the largest coordinate: far above all rounding
  };
  static const Options<Config>& options() {
    static const Options<Config> table =
        Options<Config>().add("padding", &Config::padding, 1e-9, 1.0, "widening, relative to the largest coordinate");
    return table;
  }
  explicit SphereCulling(const Config& config) : config_(config) {}

  void run(const Step& step, StageState&, unsigned, PairBatch& batch) const override {
    batch.cull([&](ElementPair pair, FeatureMask&) {
      const Sphere a = sphere(step, pair.a), b = sphere(step, pair.b);
      // Written so that a NaN or an infinity (overflow) keeps the pair: a stage that is called conservative never guesses.
      const bool apart = (a.centre - b.centre).norm() > a.radius + b.radius + step.separation;
      return apart ? PairVerdict::disjoint : PairVerdict::keep;
    });
  }

 private:
  struct Sphere {
    Vec3 centre = Vec3::Zero();
    double radius = 0;
  };

  /// Around all control points of an element's vertices, and so around its whole motion (convex-hull property).
  Sphere sphere(const Step& step, Index element) const {
    const int points = step.motion.control_points();
    Eigen::AlignedBox3d box;
    for (const Index v : step.mesh().vertices(element))
      for (int c = 0; c < points; ++c) box.extend(step.motion.point(v, c));
    Sphere result{box.center(), 0};
    for (const Index v : step.mesh().vertices(element))
      for (int c = 0; c < points; ++c)
        result.radius = std::max(result.radius, (step.motion.point(v, c) - result.centre).norm());
    result.radius += config_.padding * std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff());
    return result;
  }

  Config config_;
};

}  // namespace

int main(int argc, char** argv) {
  Registry registry = Registry::standard();
  registry.add(describe_stage<ElementCulling, SphereCulling>("spheres", "drops pairs whose swept bounding spheres are apart",
                                                             Guarantee::conservative));
  PipelineSpec spec = registry.pipeline("VolCCD+");
  spec.name = "Spheres";
  spec.description = "VolCCD+ with bounding spheres in the place of CSAT";
  spec.element_culling = {{"spheres", {}}};
  registry.add_pipeline(spec);
  return program(argc, argv, registry);
}
