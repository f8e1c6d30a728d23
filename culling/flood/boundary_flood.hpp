// The flood `boundary-flood`: finds all contacts of a volume from its boundary (docs/boundary_flood.md).
#pragma once

#include <volccd/culling/flood/flood.hpp>

namespace volccd {

/// The broad phase pairs only boundary faces, and the simplices at vertices whose star is not proven to remain embedded
/// throughout the step (suspect stars). From the pairs that element culling keeps, and from suspect pairs of adjacent
/// simplices, the flood proceeds across faces to pairs with simplices inside the volume. Of the O-Set, it omits every
/// feature pair that is covered by two adjacent simplices which are proven to have no double points. With a separation,
/// all this is proven for vertices that are displaced by up to half of it.
///
/// Accepts a step unless
///  - the share of elements that have a boundary face or are shells exceeds `max_boundary_fraction`: almost everything is
///    boundary;
///  - the share of elements that have to be divided into tetrahedra exceeds `max_divided_fraction`: there are several simplices
///    for each of them, and their topology has to be edited with the mesh;
///  - the share of vertices with suspect stars exceeds `max_suspect_fraction`, as in rubble: the flood would test more pairs
///    than a broad phase over all elements (docs/performance.md has the measurements for these limits);
///  - initial overlaps are requested and the mesh is not simplicial: the hulls of other elements may overlap where
///    their simplices do not.
///
/// Gives up a step, which the pipeline then restarts without the flood, when it has proposed more than `max_pairs`
/// pairs per simplex: if element culling separates few pairs, the flood would proceed through the whole volume.
///
/// prepare(): linear time in the number of simplices. Memory: about 140 bytes per simplex, or about 550 for meshes with
/// elements other than tetrahedra and triangles, which require a second topology.
class BoundaryFlood final : public Flood {
 public:
  struct Config {
    double max_boundary_fraction = 0.8;  ///< largest share of elements
    double max_divided_fraction = 0.5;   ///< largest share of elements
    double max_suspect_fraction = 0.03;  ///< largest share of vertices
    double max_pairs = 4;       ///< largest number of proposed pairs per simplex
  };
  static const Options<Config>& options();

  /// Counters of the last step.
  struct Counters {
    std::size_t simplices = 0;   ///< all simplices
    std::size_t paired = 0;      ///< simplices of which the broad phase pairs a face or the whole
    std::size_t suspect_vertices = 0;
    std::size_t looked_at = 0;        ///< pairs that next() proposed
    std::size_t looked_at_start = 0;  ///< those proposed for t = 0
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

  /// The counters of a state that a BoundaryFlood created.
  static const Counters& counters(const StageState& state);

 private:
  Config config_;
};

StageDescriptor<Flood> describe_boundary_flood();

}  // namespace volccd
