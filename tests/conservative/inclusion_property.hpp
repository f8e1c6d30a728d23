// The promises of the header of `inclusion` as a property of generated tests.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <volccd/narrowphase/inclusion/inclusion.hpp>
#include <volccd/query/contact.hpp>

#include "conservative/one_test.hpp"
#include <volccd/oracle/cases/instruction_sets.hpp>

namespace volccd::test {

/// Makes a test from choices.
using Generator = std::function<Case(Choices&)>;

/// The answer of `inclusion` to a test.
struct Answer {
  std::vector<Contact> contacts;
  NarrowCounters counters;

  bool found() const { return !contacts.empty(); }
  const Contact& contact() const { return contacts.front(); }
  bool operator==(const Answer& other) const {
    return contacts == other.contacts && counters.undecided == other.counters.undecided;
  }
};

/// Returns "", or a description of the error. The answer is that of the best instruction set; all others must give the
/// same.
class InclusionProperty {
 public:
  enum class Promise {
    /// No contact is missed or late, or early by more than the tolerance; undecided=exact gives the exact answer, and
    /// t_max is respected.
    complete,
    near       ///< features of reported contacts are near each other
  };

  enum class Others {
    all,     ///< each instruction set on every test
    /// one instruction set for each test, for large numbers of tests, because all sets take up to six times as long
    in_turn
  };

  InclusionProperty(Promise promise, Generator generator, Others others = Others::all)
      : promise_(promise), generator_(std::move(generator)), others_(others) {}

  std::string operator()(Choices& choices);
  /// Checks one test.
  std::string judge(const Case& c);

 private:
  Answer run(const Inclusion& inclusion, const Case& c, double t_max);
  std::string wrong_touch(const Case& c, const Answer& answer);
  std::string wrong_distance(const Case& c, const Answer& answer);
  std::string wrong_by_then(const Case& c, const Answer& answer);
  std::string wrong_target(const Case& c, const Answer& answer);
  bool near(const Case& c, const Answer& answer);
  bool cut_short(const Case& c, const Answer& answer);
  static bool spans_too_much(const Case& c, const Answer& answer);

  Promise promise_;
  Generator generator_;
  Others others_;
  static constexpr double kTolerance = 1e-9;
  Inclusion plain_{{.time_tolerance = kTolerance}};
  Inclusion deciding_{{.time_tolerance = kTolerance, .undecided = Undecided::exact}};
  Inclusion patient_{{.time_tolerance = kTolerance, .max_parts = 100'000}};
  VectorTargets targets_;
  std::size_t compared_ = 0;
  OneTest test_;
};

}  // namespace volccd::test
