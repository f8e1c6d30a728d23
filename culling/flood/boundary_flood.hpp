// The flood `boundary-flood`: finds all contacts of a volume from its boundary (docs/boundary_flood.md).
#pragma once

#include <volccd/query/roles/flood.hpp>

namespace volccd {

/// The broad phase pairs only boundary faces, and the simplices at vertices whose star is not proven to remain embedded
/// throughout the step (suspect stars). From the pairs that element culling keeps, and from suspect pairs of adjacent
/// simplices, the flood proceeds across faces to pairs with simplices inside the volume. Of the O-Set, it omits every
/// feature pair that is covered by two adjacent simplices which are proven to have no double points. With a separation,
/// all this is proven for vertices that are displaced by up to half of it.
///
/// Accepts a step unless
///  - the share of elements that have a boundary face or are shells exceeds `max_boundary_fraction`: almost everything
///  is
///    boundary;
///  - the share of elements that have to be divided into tetrahedra exceeds `max_divided_fraction`: there are several
///  simplices
///    for each of them, and their topology has to be edited with the mesh;
///  - the share of vertices with suspect stars exceeds `max_suspect_fraction`, as in rubble: the flood would test more
///  pairs
///    than a broad phase over all elements (docs/performance.md has the measurements for these limits);
///  - initial overlaps are requested and the mesh is not simplicial: the hulls of other elements may overlap where
///    their simplices do not.
///
/// When it has examined more than `max_pairs` pairs for each simplex, it hands out all pairs of simplices that its
/// broad phase finds, except those that it has already handed out for the whole step: if element culling separates few
/// pairs, the flood would proceed through the whole volume.
///
/// prepare(): linear time in the number of simplices. Memory: about 140 bytes per simplex, or about 550 for meshes with
/// elements other than tetrahedra and triangles, which require a second topology.
class BoundaryFlood final : public Flood {
 public:
  struct Config {
    double max_boundary_fraction = 0.8;  ///< largest share of elements
    double max_divided_fraction = 0.5;   ///< largest share of elements
    double max_suspect_fraction = 0.03;  ///< largest share of vertices
    double max_pairs = 4;                ///< largest number of proposed pairs per simplex
  };
  static const Options<Config>& options();

  /// Counters of the last step.
  struct Counters {
    std::size_t simplices = 0;  ///< all simplices
    std::size_t paired = 0;     ///< simplices of which the broad phase pairs a face or the whole
    std::size_t suspect_vertices = 0;
    std::size_t examined = 0;           ///< pairs handed out after those of outer parts
    std::size_t examined_at_start = 0;  ///< of these, for t = 0 only
    bool all_paired = false;            ///< whether all pairs of simplices were handed out
  };

  explicit BoundaryFlood(const Config& config) : config_(config) {}

  std::unique_ptr<StageState> make_state_with(const BroadPhase& broad_phase) const override;
  void prepare(const Step& step, StageState& state, Executor& executor) const override;
  bool uses_cut_stars() const override { return true; }
  bool takes(const StageState& state, bool overlaps) const override;
  const Step& step(const StageState& state) const override;
  Round next_round(const Step& step, StageState& state, std::size_t number, Executor& executor) const override;
  void run(const Step& step, StageState& state, unsigned worker, std::size_t block, Work& out) const override;
  void record_survivors(StageState& state, unsigned worker, std::span<const ElementPair> pairs) const override;
  void to_mesh_features(const StageState& state, TestBatch& tests, std::size_t vf_begin,
                        std::size_t ee_begin) const override;

  /// Those of the broad phase, and "outer_parts", "suspect_vertices" and "examined_pairs" (Counters).
  void append_counters(const StageState& state, std::vector<StageCounter>& out) const override;

  /// The counters of a state that a BoundaryFlood created.
  static const Counters& counters(const StageState& state);

 private:
  Config config_;
};

StageDescriptor<Flood> describe_boundary_flood();

}  // namespace volccd
