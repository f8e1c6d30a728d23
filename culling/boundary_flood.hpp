// The flood `boundary-flood`: all contacts of a volume from its boundary (docs/boundary_flood.md).
#pragma once

#include <volccd/culling/flood.hpp>

namespace volccd {

/// Classifies the simplices of a step: those with a boundary face, and those whose volume is not proven to keep its
/// sign (D), are what the broad phase pairs. From the pairs of these that element culling keeps, and from stars that
/// may fold, it goes on over face neighbours to pairs with simplices inside the volume. Of the O-Set it lists the pairs
/// all of whose common vertices have suspect stars.
///
/// Takes a step unless
///  - more than `most_boundary` of the elements have a boundary face, or are shells: the boundary is all there is;
///  - more than `most_suspect` of the vertices have stars that may fold, as in rubble: the flood would look at more
///    than a broad phase over everything (docs/boundary_flood.md has the measurements behind both);
///  - the separation is above 0: the theorem's conditions on stars are for contact only;
///  - initial overlaps are asked for and the mesh is not its own complex: hulls of other elements may overlap where
///    their simplices do not.
///
/// It gives a step up, to be begun anew without it, when it has proposed more than `most_pairs` pairs for each simplex:
/// where element culling separates few pairs, it would go on through all of the volume.
///
/// prepare: linear in the simplices. Memory: about 140 bytes a simplex; some 550 for meshes of other elements than
/// tetrahedra and triangles, which need a second topology.
class BoundaryFlood final : public Flood {
 public:
  struct Config {
    double most_boundary = 0.8;  ///< share of the elements
    double most_suspect = 0.03;  ///< share of the vertices
    double most_pairs = 4;       ///< looked at, for each simplex
  };
  static const Options<Config>& options();

  /// Of the last step.
  struct Counters {
    std::size_t simplices = 0;   ///< all of them
    std::size_t degenerate = 0;  ///< in D
    std::size_t paired = 0;      ///< in the broad phase
    std::size_t suspect_vertices = 0;
    std::size_t looked_at = 0;        ///< pairs that next() proposed
    std::size_t looked_at_start = 0;  ///< those of them for t = 0
  };

  explicit BoundaryFlood(const Config& config) : config_(config) {}

  std::unique_ptr<StageState> make_state() const override;
  void prepare(const Step& step, StageState& state, Executor& executor) const override;
  bool takes(const StageState& state, bool overlaps) const override;
  Step step(const StageState& state) const override;
  void reach(StageState& state, unsigned worker, const std::vector<ElementPair>& pairs) const override;
  Front next(StageState& state, Executor& executor) const override;
  void to_mesh_features(const StageState& state, TestBatch& tests, std::size_t vf_begin,
                        std::size_t ee_begin) const override;
  std::size_t orphan_blocks(const StageState& state) const override;
  void orphans(const StageState& state, std::size_t block, TestBatch& out) const override;

  /// Of a state that a BoundaryFlood made.
  static const Counters& counters(const StageState& state);

 private:
  Config config_;
};

StageDescriptor<Flood> describe_boundary_flood();

}  // namespace volccd
