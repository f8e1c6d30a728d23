// All elementary tests and initial overlaps of a step, enumerated without any stage, and their exact results.
// Coordinates are integers, so that most tests are proven apart by integer arithmetic without rounding.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <volccd/query/contact.hpp>
#include <volccd/query/step.hpp>

namespace volccd::fuzz {

/// Pre: the coordinates of the motion are integers of at most MeshScript::kMaxCoordinate. The
/// referenced step must outlive this object.
class LatticeTests {
 public:
  explicit LatticeTests(const Step& step);

  /// A text on a test that is in contact in [0, t_max] but has no contact, or on a contact whose test is not included
  /// in the step or is proven apart; empty if there is neither. `contacts` are in canonical order.
  std::string problem(std::span<const Contact> contacts);
  /// Number of tests that integer arithmetic does not prove apart.
  std::size_t open_tests() const { return tests_.size(); }

 private:
  struct Test {
    FeatureKind kind;
    FeaturePair pair;
    std::array<Index, 4> vertices;
    std::optional<double> toi;  ///< if decided; negative: no contact
  };

  void enumerate();
  void add(FeatureKind kind, FeaturePair pair);
  /// Whether an integer predicate proves that the features do not touch.
  bool apart(FeatureKind kind, const std::array<Index, 4>& vertices) const;
  bool in_contact(Test& test) const;

  const Step& step_;
  std::vector<std::int64_t> coordinates_;  ///< [vertex][control point][axis]
  std::vector<Test> tests_;                ///< those that are not proven apart, in canonical order
};

/// Element pairs as in StepResult::initial_overlaps.
std::vector<ElementPair> initial_overlaps(const Step& step);

/// Whether the filter includes a feature pair, by the definition in ObjectFilter.
bool is_included(const Step& step, FeatureKind kind, FeaturePair pair);

}  // namespace volccd::fuzz
