#include <volccd/culling/csat.hpp>

#include <volccd/culling/detail/csat_kernel.hpp>

namespace volccd {

const Options<Csat::Config>& Csat::options() {
  static const Options<Config> options =
      Options<Config>()
          .add("axis", &Config::axis,
               {{"face", CsatAxis::face},
                {"predetermined", CsatAxis::predetermined},
                {"velocity", CsatAxis::velocity},
                {"centroid", CsatAxis::centroid},
                {"optimal", CsatAxis::optimal}},
               "where the separating axis comes from; face is the paper's")
          .add("mode", &Config::mode,
               {{"features", CsatMode::features}, {"pair", CsatMode::pair}, {"both", CsatMode::both}},
               "Algorithm 2 (features), one axis for the whole pair, or both in turn")
          .add("iterations", &Config::iterations, 1, 64, "most axes that optimal tries")
          .add("edges_of_b", &Config::edges_of_b, "features mode tests the edges of the second element, too");
  return options;
}

void Csat::run(const Step& step, StageState&, unsigned, PairBatch& batch) const {
  detail::csat_cull(config_, step, batch);
}

StageDescriptor<ElementCulling> describe_csat() {
  return describe_stage<ElementCulling, Csat>("csat", "continuous separating axis test of element pairs (Section 4)",
                                              Guarantee::conservative);
}

}  // namespace volccd
