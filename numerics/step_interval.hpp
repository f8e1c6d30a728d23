// The time interval of a step to which a query is restricted.
#pragma once

#include <algorithm>

namespace volccd {

/// The interval [0, s] of a step, s = t_max in [0, 1], as weights of de Casteljau's algorithm: control point c of the
/// motion over the interval is the first value of level c.
struct StepInterval {
  int levels;      ///< levels of the algorithm: 0 for the whole step, otherwise the degree of the motion
  double s, rest;  ///< rest = 1 - s

  StepInterval(double t_max, int control_points)
      : levels(t_max < 1 ? control_points - 1 : 0), s(std::max(t_max, 0.0)), rest(1 - s) {}
};

}  // namespace volccd
