// The part of a step that a query asks for.
#pragma once

#include <algorithm>

namespace volccd {

/// [0, s] of a step, s = t_max in [0, 1], as weights of de Casteljau's scheme: control point c of the motion over the
/// part is the first value of level c.
struct StepPart {
  int levels;      ///< of the scheme: 0 for all of the step, else the degree of the motion
  double s, rest;  ///< rest = 1 - s

  StepPart(double t_max, int control_points)
      : levels(t_max < 1 ? control_points - 1 : 0), s(std::max(t_max, 0.0)), rest(1 - s) {}
};

}  // namespace volccd
