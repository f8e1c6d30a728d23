// When candidate lists are made, how far ahead and with which budget.
#pragma once

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
/// fresh steps would. A list is made after two steps whose motions agree, if it is expected to serve at least
/// kMinSteps; its number of steps and its budget follow what the last lists were used for. What lists cost is paid from
/// a credit: a share of the time of fresh steps, and what earlier lists saved. Knows nothing of lists, so that it can
/// be tested with made-up times.
class ListPolicy {
 public:
  struct Plan {
    double steps, budget;
  };
  /// The motion of the present step.
  struct Motion {
    double length;    ///< the longest way of a vertex
    double distance;  ///< how far the motion is from the one before it, going on; infinite if that is unknown
    double edge;      ///< a typical length of an edge
  };

  /// Whether a list is to be made now, and how.
  std::optional<Plan> plan(const Motion& motion);
  void record_fresh(double seconds);
  /// `build`: the time that it took to make the list, `seconds` that of the step with it.
  void record_list(double build, double seconds);
  void record_reuse(double seconds);
  /// The list was used up: by steps that are farther than the budget from the prediction, or by the steps planned.
  /// `distance`: the largest distance of a step that it covered.
  void record_end(bool by_budget, double distance);

  static constexpr double kMinSteps = 6;

 private:
  static constexpr double kShare = 0.02;    ///< of the time of fresh steps, that lists may cost
  static constexpr double kMaxCredit = 20;  ///< in times of fresh steps
  static constexpr double kFirstCost = 3;   ///< of a list, before one was measured, in times of a fresh step
  static constexpr double kMaxSteps = 4096;

  void pay(double seconds);

  double fresh_ = 0;            ///< seconds of a fresh step
  double credit_ = kFirstCost;  ///< in times of a fresh step
  double cost_ = kFirstCost;    ///< of a list, in times of a fresh step
  double reach_ = 0.25;         ///< way of the fastest vertex that a list is made for, in edges
  double ratio_ = 0.125;        ///< budget, in ways of the fastest vertex
  double trend_ = 1.5;          ///< by which reach_ is multiplied next
  double last_mean_ = 0;        ///< mean time of a step with the list before, in times of a fresh step
  double spent_ = 0;            ///< with the present list, in seconds
  double planned_steps_ = 0, planned_budget_ = 0;
  int used_ = 0;  ///< steps with the present list
};

}  // namespace volccd
