// Which features of a mesh collide.
#pragma once

namespace volccd::simulation {

/// Figure 3 of the paper sets the first against one of the others.
enum class ContactFeatures {
  all,       ///< every pair of features, interior ones too
  boundary,  ///< pairs of features that both lie on the boundary of the mesh as it is at the time: cracks have faces
  surface    ///< those that lay on the boundary when the simulation began, as a collision code for surfaces has it
};

}  // namespace volccd::simulation
