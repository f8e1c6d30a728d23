// The orphans that can touch at all in a step, listed from the stars that may fold (docs/star_orphans.md).
#pragma once

#include <volccd/query/roles/orphan_source.hpp>

namespace volccd {

/// Every orphan has its features in elements that share a vertex. If the star of that vertex, which consists of all
/// elements at it, is proven to remain embedded throughout the step, features of the star without a common vertex
/// cannot touch, or with a separation come within it. In solids that neither invert nor fold, nearly all stars are, so
/// that hardly any orphan has to be listed or tested, and no O-Set is stored.
///
/// The state contains an OSet as well, which provides the orphans if stars decide too little: if the mesh has no volume
/// elements but thickened shells whose neighbours are left out, or if more than the fraction `max_suspect_fraction` of
/// the vertices have stars that may fold. It is built, and updated, only for such steps.
class StarOrphans final : public OrphanSource {
 public:
  struct Config {
    double max_suspect_fraction = 0.25;
  };
  static const Options<Config>& options();

  explicit StarOrphans(const Config& config) : config_(config) {}

  std::unique_ptr<StageState> make_state() const override;
  void prepare(const Step& step, StageState& state, Executor& executor) const override;
  std::size_t blocks(const StageState& state) const override;
  void run(const Step& step, StageState& state, unsigned worker, std::size_t block, Work& out) const override;

  struct Counters {
    std::size_t suspect_vertices = 0;  ///< vertices whose stars may fold
    std::size_t pairs = 0;             ///< pairs of elements whose orphans were listed
    bool by_stars = false;             ///< false: the O-Set provides the orphans
  };
  /// The results of the last prepare().
  static const Counters& counters(const StageState& state);

 private:
  Config config_;
};

StageDescriptor<OrphanSource> describe_star_orphans();

}  // namespace volccd
