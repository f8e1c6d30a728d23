#include <volccd/mesh/thickened_shells.hpp>

#include <algorithm>

#include <volccd/mesh/edit_between.hpp>

namespace volccd {

ThickenedShells::ThickenedShells(Mesh mesh, std::vector<double> thickness)
    : mesh_(std::move(mesh)), thickness_(std::move(thickness)), thickener_(mesh_) {
  thickener_.check_thickness(thickness_);
}

ThickenedShells ThickenedShells::edited(const TopologyEdit& edit, std::span<const double> thickness) const {
  Mesh mesh = mesh_;
  std::vector<double> values = thickness_;
  for (const Index slot : edit.removed) mesh.remove_element(slot);
  mesh.add_vertices(edit.new_vertex_ids);
  for (std::size_t i = 0; i < edit.added.size(); ++i) {
    const Index slot = mesh.add_element(edit.added[i]);
    values.resize(mesh.element_slots(), 0.0);
    values[slot] = thickness[i];
  }
  return ThickenedShells(std::move(mesh), std::move(values));
}

TopologyEdit ThickenedShells::edit_of_solids(const Mesh& solids) const {
  std::vector<ElementSpec> specs;
  for (Index o = 0; o < mesh_.element_slots(); ++o)
    if (mesh_.is_live(o)) specs.push_back(thickener_.solid_element(mesh_, o));
  const auto is_same = [&](std::size_t i, Index o) {
    return solids.type(o) == specs[i].type && solids.object(o) == specs[i].object &&
           std::ranges::equal(solids.vertices(o), specs[i].vertices) &&
           std::ranges::equal(solids.polytope_faces(o), specs[i].faces);
  };
  TopologyEdit edit = edit_between(
      solids, specs.size(), [&](std::size_t i) { return specs[i].id; }, is_same,
      [&](std::size_t i) { return std::move(specs[i]); });
  edit.new_vertex_ids = solid_vertex_ids(mesh_.vertex_ids().subspan(solids.vertex_count() / 3));
  return edit;
}

}  // namespace volccd
