#include <volccd/io/sequence/detail/shell_solids.hpp>

#include <volccd/core/error.hpp>

namespace volccd::detail {

ShellSolids::ShellSolids(SequenceReader& reader) : reader_(reader) {
  if (reader.point_count() >= kNone / 3)
    throw InputError(reader.file(), "VTKHDF/NumberOfPoints", 0,
                     "more than 2^32 - 2 points, once tripled for solid shells");
  try {
    vertex_ids_ = solid_vertex_ids(reader.point_ids());
  } catch (const InputError& error) {
    throw InputError(reader.file(), "VTKHDF/PointData/GlobalPointIds", error.what());
  }
}

void ShellSolids::set_cells(const SequenceCells& cells) {
  mesh_ = mesh_of(reader_.point_ids(), cells);
  thickener_.emplace(mesh_);
  solids_.clear();
  for (Index o = 0; o < mesh_.element_slots(); ++o) solids_.add(thickener_->solid_element(mesh_, o));
}

void ShellSolids::read_thickness(int start, int end) {
  const Index cells = mesh_.element_slots();
  if (!reader_.has_thickness()) {
    for (Index o = 0; o < cells; ++o)
      if (is_shell(mesh_.type(o)))
        throw InputError(reader_.file(), "VTKHDF/CellData/Thickness", "is missing: without it shells cannot be solids");
    thickness0_.assign(cells, 0);
    thickness1_.assign(cells, 0);
    return;
  }
  reader_.read_thickness(end, thickness1_);
  thickness0_ = thickness1_;
  if (start == end) return;
  if (reader_.same_cells(start, end)) return reader_.read_thickness(start, thickness0_);
  reader_.read_thickness(start, thickness_before_);
  reader_.read_cells(start, before_);
  for (std::size_t i = 0; i < before_.size(); ++i)
    if (const Index o = mesh_.find_element(before_.ids[i]); o != kNone) thickness0_[o] = thickness_before_[i];
}

Index ShellSolids::positions(int start, int end, std::span<const Vec3> x0, std::span<const Vec3> x1,
                             std::vector<Vec3>& solid0, std::vector<Vec3>& solid1) {
  read_thickness(start, end);
  const Index without0 = thickener_->positions(x0, thickness0_, solid0, scratch_, serial_executor());
  return without0 + thickener_->positions(x1, thickness1_, solid1, scratch_, serial_executor());
}

}  // namespace volccd::detail
