// Elementary tests with known answers, wherever they are from: what `volccd queries` runs narrow phases on.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <volccd/mesh/sequence/stepper.hpp>
#include <volccd/query/step.hpp>

namespace volccd {

/// Tests of one kind on one step.
struct KnownQueries {
  std::string scene;
  FeatureKind kind;
  Step step;
  std::shared_ptr<const void> owner;  ///< of what `step` refers to
  std::vector<FeaturePair> pairs;
  std::vector<std::uint64_t> index;    ///< of each pair in its file, or among all candidates
  std::vector<std::uint8_t> collides;  ///< empty where nothing is known, else one a pair
  std::vector<double> toi;             ///< empty where nothing is known, else one a pair, NaN where there is none
  std::function<std::string(std::uint64_t index)> place;  ///< where a query is from, for a message

  std::size_t size() const { return pairs.size(); }
};

struct QuerySourceConfig {
  /// Of a sequence: all pairs with overlapping swept boxes, not those alone that its ground truth lists.
  bool candidates = false;
  /// At most so many of each scene and kind, drawn alike on every run; 0: all.
  std::size_t sample = 0;
  int motion = 0;                   ///< of a sequence
  SequenceStepper::Config stepper;  ///< how it is read
  std::function<void()> check;      ///< called often while candidates are collected; may throw to stop
};

/// Of a query file, or of a motion of a sequence: the pairs in its ground truth or, with `candidates`, all pairs
/// without a common vertex whose closed swept boxes overlap. The truth is that of motion 0: there, what it does not
/// list does not touch; of candidates of another motion, or of a sequence without truth, nothing is known. Throws
/// InputError; also for a sequence or a motion without truth unless candidates are wanted, and for a pair in the truth
/// that the mesh does not have.
std::vector<KnownQueries> load_queries(const std::string& file, const QuerySourceConfig& config);

}  // namespace volccd
