// The front of a car, of thin sheet.
#pragma once

#include <array>
#include <cstdint>

#include <volccd/oracle/cases/shapes.hpp>

namespace volccd {

/// Objects of the mesh.
enum class VehiclePart : std::int32_t {
  bumper_beam,
  crash_boxes,
  rails,
  cross_members,
  radiator,
  upper_rails,
  aprons,
  hood,
  fenders,
  fascia,
  firewall,
  floor,
  sides,
  windscreen,
  wheels,
  engine,
  mounts,
  rear
};
inline constexpr std::int32_t kVehicleParts = 18;

const char* to_string(VehiclePart part);

/// About `triangles` triangles (within 1 % from some 5,000 on), all parts joined by shared vertices into one piece: a
/// closed bumper beam on two crash boxes and rails with beads, which run under the floor; radiator support, upper rails
/// and aprons; firewall, floor with a tunnel, sides, windscreen and roof; hood on two hinges and a latch; fenders,
/// front fascia; wheels, engine block and their mounts; and a bulkhead behind, which represents the rest of the car.
///
/// Metres: x to the rear from about -0.06 to 1.85, z up from 0.01 to 1.35, symmetric about y = 0. Element ids 0, 1, ..
/// Throws ConfigError for too few triangles (about 1,100).
Shape vehicle_front(int triangles);

}  // namespace volccd
