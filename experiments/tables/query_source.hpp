// Elementary tests with known answers from files of several kinds: the input of `volccd queries`.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <volccd/io/sequence/stepper.hpp>
#include <volccd/query/step.hpp>

namespace volccd {

/// Tests of one kind on one step.
struct KnownQueries {
  std::string scene;
  FeatureKind kind;
  Step step;
  std::shared_ptr<const void> owner;  ///< owner of the objects to which `step` refers
  std::vector<FeaturePair> pairs;
  std::vector<std::uint64_t> index;                       ///< index of each pair in its file, or among all candidates
  std::vector<std::uint8_t> collides;                     ///< by pair; empty if no answers are known
  std::vector<double> toi;                                ///< by pair, NaN if it has none; empty if no times are known
  std::function<std::string(std::uint64_t index)> place;  ///< origin of a query, for messages

  std::size_t size() const { return pairs.size(); }
};

struct QuerySourceConfig {
  /// For a sequence: use all pairs with overlapping swept boxes instead of the pairs listed in its ground truth.
  bool candidates = false;
  /// Greatest number of queries of each scene and kind; every run draws the same ones. 0: all.
  std::size_t sample = 0;
  int step = 0;                     ///< of a sequence
  SequenceStepper::Config stepper;  ///< how the sequence is read
  std::function<void()> check;      ///< called often while candidates are collected; may throw to stop
};

/// Loads the queries of a query file, or of a step of a sequence: the pairs in its ground truth or, with
/// `candidates`, all pairs without a common vertex whose closed swept boxes overlap. The ground truth is that of step
/// 0; pairs that it does not list do not touch. For candidates of another step, or of a sequence without ground
/// truth, no answers are known. Throws InputError for an invalid file, for a sequence or a step without ground truth
/// unless `candidates` is set, and for a pair in the ground truth that is not in the mesh.
std::vector<KnownQueries> load_queries(const std::string& file, const QuerySourceConfig& config);

}  // namespace volccd
