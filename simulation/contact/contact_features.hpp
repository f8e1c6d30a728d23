// Which features of a mesh collide.
#pragma once

namespace volccd::simulation {

/// Figure 3 of the paper compares `all` with one of the others.
enum class ContactFeatures {
  all,       ///< all features, interior ones included
  boundary,  ///< features on the boundary of the present mesh, which includes the faces of cracks
  surface    ///< features that were on the boundary when the simulation began, as in many collision codes
};

}  // namespace volccd::simulation
