// When candidate lists are made, how far ahead and with which budget.
#pragma once

#include <algorithm>
#include <limits>
#include <optional>

namespace volccd {

/// How a StepRunner uses candidate lists (CandidateList). The contacts do not depend on it.
struct ListConfig {
  enum class Use {
    never,
    automatic,  ///< where steps become faster, as measured (ListPolicy)
    always      ///< with the budget and the number of steps below
  };
  Use use = Use::never;
  double budget = 0;  ///< of Use::always: a distance in the unit of the coordinates, finite, >= 0
  double steps = 0;   ///< of Use::always: how many steps ahead the motion is expected to go on; 0: to rest
};

/// Decides from measured times where lists are made, so that all steps together take at most a few percent more than
/// fresh steps would. A list is made if it is expected to serve at least kMinSteps, from how far earlier steps got
/// from a prediction; how far it goes follows from what earlier lists cost and were used for. What lists cost is paid
/// from a credit: a share of the time of fresh steps, and what earlier lists saved. Knows nothing of lists, so that it
/// can be tested with made-up times.
class ListPolicy {
 public:
  struct Plan {
    double steps, budget;
  };
  /// The motion of the present step.
  struct Motion {
    double length;    ///< the greatest distance that a vertex moves
    double distance;  ///< of vertices from where they were expected `steps` steps ago; infinite if nothing was expected
    double steps;     ///< >= 1
    double edge;      ///< a typical length of an edge
  };

  /// How far the fastest vertex may move while a list serves, in edges.
  double max_travel() const { return max_travel_; }
  /// The greatest budget of a list, in edges. With greater ones, all features of neighbouring elements are near.
  double max_budget() const { return std::min(max_travel_ / 4, 1.0 / 16); }

  /// Whether a list can be paid for. If not, plan() need not be asked.
  bool has_credit() const { return fresh_steps_ > 0 && cost_ - 1 <= credit_; }
  /// Whether a list is to be made now, and how.
  std::optional<Plan> plan(const Motion& motion);

  void record_fresh(double seconds);
  /// A list was made in `build` seconds.
  void record_list(double build);
  /// A step took `seconds` with the list, of which tests without a contact took `in_vain`.
  void record_use(double seconds, double in_vain);
  /// Whether steps with the present list take less time than fresh ones. If not, it is to be given up.
  bool is_worthwhile() const;
  /// The list is no longer used. `covered`: the largest distance of a step that it covered from its prediction;
  /// `missed`: that of the step that it does not cover, 0 if its steps were used up; `seconds`: the time it took to see
  /// this.
  void record_end(double covered, double missed, double seconds);

  static constexpr double kMinSteps = 5;

 private:
  static constexpr double kShare = 0.03;     ///< of the time of fresh steps, that lists may cost
  static constexpr double kMaxCredit = 20;   ///< in times of a fresh step
  static constexpr double kFirstCost = 1.5;  ///< of a list, before one was made, in times of a fresh step
  static constexpr double kFirstTravel = 0.25;
  static constexpr double kForgotten = 0.02;  ///< part of what is known about lists, by each fresh step
  static constexpr double kMaxSteps = 64;     ///< of a list, in steps since the prediction that tells about the motion

  int fresh_steps_ = 0;
  double fresh_ = 0;                  ///< seconds of a fresh step; the first one, which builds tables, does not count
  double credit_ = kFirstCost - 1;    ///< in times of a fresh step; the first list needs no waiting
  double cost_ = kFirstCost;          ///< of a list, in times of a fresh step
  double max_travel_ = kFirstTravel;  ///< max_travel()
  double change_ = 1.5;               ///< by which factor max_travel() changes after a list
  double price_ = std::numeric_limits<double>::infinity();  ///< of a step with the last list
  double ratio_ = 1.0 / 64;  ///< part of the budget that is proportional to this distance
  // of the present list
  double build_ = 0, wasted_ = 0, used_ = 0;  ///< seconds
  double planned_steps_ = 0, planned_budget_ = 0;
  int uses_ = 0;
};

}  // namespace volccd
